"""The samples that the program comes with, as documents to try things on."""

from assets import asset
from core.curves import feature_curves
from core.document.document import CurvePair, Document, Mode, places_from_pixels
from core.imaging.images import load, load_mask
from core.rasters.raster import Raster


def warp_sample() -> Document:
    """Return balloons over hills, painted as features."""
    document = Document.of(load(asset("balloons.png")))
    return document.changed(mask=Raster.from_array(load_mask(asset("balloons_mask.png"), document.size_px)))


def retexture_sample() -> Document:
    """Return a fox with curves along its tail, which lie where they are."""
    document = Document.of(load(asset("fox_tail.png")))
    curves = []
    for curve in feature_curves.read(asset("fox_tail_curves.json")):
        places = places_from_pixels(document.size_px, curve.source.points)
        curves.append(CurvePair(places, places, curve.source.closed, curve.passive))
    return document.changed(feature_curves=tuple(curves), mode="retexture")


def overlay_sample() -> Document:
    """Return a photograph of printed cloth in folds, whose pattern is not looked for yet."""
    return Document.of(load(asset("folded_print.png"))).changed(mode="overlay")


def sample_of(mode: Mode) -> Document:
    """Return the sample of a mode."""
    made = {"warp": warp_sample, "retexture": retexture_sample, "overlay": overlay_sample}
    return made[mode]()
