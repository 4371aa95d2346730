"""Every tool, in the order of the toolbar."""

from collections.abc import Mapping
from types import MappingProxyType

from app.editor.tool import Tool
from app.tools.brush import BRUSH
from app.tools.cloth.cloth_region import REGION, TEXEL
from app.tools.cloth.drape import DRAPE
from app.tools.cloth.lattice import LATTICE
from app.tools.curves.curves import CURVES, FEATURE_CURVE_TOOL
from app.tools.curves.trace import TRACE
from app.tools.navigate import HAND
from app.tools.outline import OUTLINE
from app.tools.pins import PINS
from app.tools.resize import RESIZE
from app.tools.select.by_colour import COLOUR_RANGE, WAND
from app.tools.select.objects import CLING, OBJECT
from app.tools.select.outlined import ELLIPSE, LASSO, POLYGON, RECTANGLE
from app.tools.split import SPLIT
from app.tools.zoom import ZOOM

SELECTING = (RECTANGLE, ELLIPSE, LASSO, POLYGON, CLING, WAND, COLOUR_RANGE, OBJECT, SPLIT)
OTHERS = (RESIZE, OUTLINE, PINS, CURVES, FEATURE_CURVE_TOOL, TRACE, DRAPE, REGION, TEXEL, LATTICE, HAND, ZOOM)
TOOLS: Mapping[str, Tool] = MappingProxyType({tool.name: tool for tool in (BRUSH, *SELECTING, *OTHERS)})
