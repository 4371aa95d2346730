"""Pictures and masks: reading, writing and what is kept of a file.

Read is whatever OpenImageIO knows; written are PNG, TIFF, EXR, JPEG, WebP and JPEG XL. What happens to the special
cases:

- EXIF orientation is applied to the pixels and reset. Other EXIF, IPTC and XMP entries and the ICC profile are kept;
  colours are not converted. (ISO speed is lost in TIFF, and so is a grey profile in WebP, which has no grey.)
- Palettes are expanded. CMYK becomes RGB, its profile goes. Of files with other channel sets red, green, blue and alpha
  are taken by name, else the first channels. Of files with several pictures the first is taken, of EXR the data window.
- Alpha is straight, as in PNG. Files that hold premultiplied colours (EXR, some TIFF) are divided on reading, EXR is
  multiplied on writing, so that a colour without any alpha is lost there.
- Float pictures are linear light; NaN becomes 0, infinities the largest finite number.
- Depth: PNG and TIFF keep 8 and 16 bits, TIFF and EXR keep float, JPEG XL keeps all three. A float picture becomes
  16-bit PNG; JPEG and WebP are 8-bit; an integer picture becomes linear light in EXR.
- JPEG XL loses all metadata but the profile; one without a profile is read with that of its colours, such as sRGB.
- JPEG has no alpha: the picture is laid on white, in linear light.
"""

from core.imaging.image import Attribute, Image
from core.imaging.reading import load, load_mask, mask_of
from core.imaging.writing import SUFFIXES, check_writable_format, save, write, writing_rows

__all__ = [
    "SUFFIXES",
    "Attribute",
    "Image",
    "check_writable_format",
    "load",
    "load_mask",
    "mask_of",
    "save",
    "write",
    "writing_rows",
]
