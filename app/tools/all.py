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
from app.tools.zoom import ZOOM

TOOLS: Mapping[str, Tool] = MappingProxyType(
    {
        tool.name: tool
        for tool in (BRUSH, OUTLINE, PINS, CURVES, FEATURE_CURVE_TOOL, TRACE, DRAPE, REGION, TEXEL, LATTICE, HAND, ZOOM)
    }
)
