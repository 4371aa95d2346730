"""A feature curve of a document, brought onto the edge that it was drawn beside."""

from dataclasses import replace

from core.arrays import InputError
from core.curves.bezier import Curve
from core.curves.edge_snapping import snap_to_edge
from core.curves.feature_curves import FeatureCurve
from core.document.document import CurvePair, pixels_from_places, places_from_pixels
from core.imaging.image import Image


def snap(pair: CurvePair, image: Image) -> CurvePair:
    """Return the pair with its source on the edge of `image` beside it, and its target moved as far; or itself."""
    try:
        source = Curve(pixels_from_places(image.size_px, pair.source), pair.closed)
        curve = FeatureCurve(source, Curve(pixels_from_places(image.size_px, pair.target), pair.closed))
    except InputError:
        return pair
    found = snap_to_edge(image, curve)
    if found is curve or found.target is None:
        return pair
    source_places, target_places = (
        places_from_pixels(image.size_px, line.points) for line in (found.source, found.target)
    )
    return replace(pair, source=source_places, target=target_places)
