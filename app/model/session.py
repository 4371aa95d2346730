"""The session: what the window shows and how the tools are set. Nothing in it is undone or saved."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeAlias

from app.model.orbit import Orbit
from app.model.spaces import View
from core.arrays import Points
from core.document.animated import Animated
from core.document.document import Document, Mode
from core.selection.combining import Combining

Compare: TypeAlias = Literal["result", "before", "split", "onion"]
"""The result, the picture before, both side by side, or the one before shining through the result."""
Heat: TypeAlias = Literal["scale", "angle", "area"]
Look: TypeAlias = Literal["original", "deformed", "retextured"]
"""What Retexture mode shows."""
Shown: TypeAlias = Literal["result", "photo", "pattern", "mesh", "shading", "detail", "reconstruction", "residual"]
"""What Overlay mode shows: the result, or a part of what was found."""
Before: TypeAlias = Literal["original", "deformed"]
Painted: TypeAlias = Literal["matte", "source_mask", "regrow"]
"""What the brush paints in Retexture mode: where the result may differ, or where texture is taken from."""

PaintedOnCloth: TypeAlias = Literal["region", "protected", "covered"]
"""What the brush paints in Overlay mode: where cloth is, what of it stays as it is, what else is covered."""


Part: TypeAlias = Literal["joined", "new", "chosen"]
"""Which feature what is painted next is of: one with what it touches, a new one, or the one that is chosen."""

SHARE_OF_SIDE = 0.08
"""Diameter of the brush to begin with, of the side of a square as large as the picture."""
LEAST_FIRST_PX = 8


@dataclass(frozen=True)
class Brush:
    """How the mask brush paints."""

    diameter_px: float = 60.0
    """In screen pixels at 100 %, that is in canvas pixels."""
    hardness: float = 0.8
    """Share of the radius that is fully painted, 0 to 1."""
    erase: bool = False

    @classmethod
    def of(cls, size_px: tuple[int, int]) -> "Brush":
        """Return the brush to begin with on a picture of this size."""
        return cls(diameter_px=max(round(SHARE_OF_SIDE * math.sqrt(size_px[0] * size_px[1])), LEAST_FIRST_PX))

    def carried(self, before_px: tuple[int, int], after_px: tuple[int, int]) -> "Brush":
        """Return the brush for a picture of another size: as large beside it as it was beside the one before."""
        factor = math.sqrt(after_px[0] * after_px[1] / (before_px[0] * before_px[1]))
        return replace(self, diameter_px=max(round(self.diameter_px * factor), 1))


@dataclass(frozen=True)
class Selecting:
    """How the tools that select are set."""

    how: Combining = "add"
    tolerance: int = 32
    """How far colours may differ from those that are clicked, of 255."""
    contiguous: bool = True
    """Whether the wand takes only what hangs together with what is clicked."""
    by_stroke: bool = False
    """Whether objects are painted over roughly, rather than put into a box."""
    refine_px: float = 4.0
    """By so much masks are grown, shrunk, smoothed and feathered, in pixels of the picture."""


Unit: TypeAlias = Literal["px", "%", "mm", "in"]


@dataclass(frozen=True)
class Resizing:
    """How the result is given another size."""

    unit: Unit = "px"
    dpi: float = 300.0
    """Pixels per inch, for lengths in print."""
    locked: bool = False
    """Whether width and height change together."""
    proposes: bool = True
    """Whether it is proposed what to keep where nothing is painted."""
    share: float = 0.25
    """How much of the picture, 0 to 1."""
    dragged_px: tuple[int, int] | None = None
    """The size that the frame was last dragged to: the view stays where the hand saw it."""


@dataclass(frozen=True)
class OutlineAids:
    """What helps to lay an outline exactly."""

    snaps: bool = True
    """Whether what is dragged snaps to the frame and to corners."""
    across: bool = False
    """Whether left and right are edited alike,"""
    down: bool = False
    """and top and bottom."""


@dataclass(frozen=True)
class Overlays:
    """What is drawn over the picture."""

    grid: bool = False
    mask: bool = True
    handles: bool = True
    outline: bool = True
    folds: bool = True
    heat: Heat | None = None
    """Which heat map of what the warp does to small things."""
    patches: bool = False
    spines: bool = False
    regrown: bool = False
    seams: bool = False
    compression: bool = False


@dataclass(frozen=True)
class Session:
    """View, tool, options and selection."""

    mode: Mode = "warp"
    tool: str = "brush"
    view: View = field(default_factory=View)
    brush: Brush = field(default_factory=Brush)
    selecting: Selecting = field(default_factory=Selecting)
    page: Literal["bend", "resize", "space"] = "bend"
    """What the panel of Warp mode is about."""
    resizing: Resizing = field(default_factory=Resizing)
    orbit: Orbit = field(default_factory=Orbit)
    """Where the camera is that looks at the surface in space."""
    select_tool: str = "rectangle"
    """Which of the tools that select was in hand last; one button stands for all."""
    part: Part = "joined"
    features: frozenset[int] = frozenset()
    """Numbers of the features that are chosen in the list, as the map calls them."""
    lit: int | None = None
    """Number of the feature that lights up, since the pointer is on it in the list."""
    overlays: Overlays = field(default_factory=Overlays)
    compare: Compare = "result"
    split: float = 0.5
    """Place of the divider of the split view, as a share of the canvas widget's width."""
    unwarped: bool = False
    """Whether Warp mode shows the picture as it was, to paint on."""
    paints_unwarped: bool = True
    """Whether it shows that as soon as something is painted."""
    timeline: bool = False
    """Whether the timeline shows, and with it what puts keys on sliders and pins."""
    frame: int = 1
    """The frame of the timeline that is shown."""
    loops: bool = True
    """Whether playing begins anew at the end."""
    selected_keys: frozenset[tuple[Animated, float]] = frozenset()
    """What has the selected keys, and at which frames they are."""
    panels: bool = True
    """Whether the panels beside the canvas show."""
    look: Look = "retextured"
    auto_retexture: bool = True
    """Whether texture is regrown as soon as the artist lets go."""
    snaps_curves: bool = True
    """Whether a feature curve that was drawn beside an edge is brought onto it."""
    look_before: Before = "original"
    """What Retexture mode shows left of the divider."""
    painted: Painted = "regrow"
    painted_on_cloth: PaintedOnCloth = "region"
    shown: Shown = "result"
    selected: frozenset[int] = frozenset()
    """Numbers of the selected pins."""
    selected_corners: frozenset[int] = frozenset()
    """Numbers of the outline's selected corners, 0 to 3 clockwise from the top left."""
    outline: OutlineAids = field(default_factory=OutlineAids)
    guides: tuple[tuple[Points, Points], ...] = field(default=(), compare=False)
    """Lines to what a dragged place of the outline snaps to, (2,) and (2,) in screen pixels."""
    selected_curve: int | None = None
    """Number of the curve that is being edited."""
    selected_knots: frozenset[int] = frozenset()
    """Numbers of its selected knots."""
    selected_vertices: frozenset[int] = frozenset()
    """Numbers of the selected vertices of the lattice."""
    curve_side: Literal["target", "source"] = "target"
    """Which of a curve's sides is edited where they coincide."""
    draft: Points | None = field(default=None, compare=False)
    """Control points (3k + 1, 2) of the curve that is being drawn, in canvas pixels."""
    draft_handles: Points | None = field(default=None, compare=False)
    """Handle, knot and handle (3, 2) of it that the pen pulls out, in canvas pixels."""
    suggestions: tuple[Points, ...] = field(default=(), compare=False)
    """Curves on offer, (3k + 1, 2) each, in places of the picture."""
    band: tuple[tuple[float, float], tuple[float, float]] | None = None
    """Corners of the rectangle that is being drawn to select, in screen pixels."""
    selection: Points | None = field(default=None, compare=False)
    """Outline (n, 2) of the selection that is being drawn, in screen pixels."""
    last_dab: tuple[float, float] | None = None
    """Where the last stroke ended, in canvas pixels; a straight line begins there."""
    pointer: tuple[float, float] | None = None
    """Where the pointer is, in screen pixels; None when it is not over the canvas."""
    hover: object = None
    """What the tool finds under the pointer: whatever its `hover` returned."""
    folder: Path | None = None
    """Where the last file was chosen; file dialogs open on it."""
    copied_warp: Document | None = field(default=None, compare=False)
    """A document whose warp was copied; only that of it counts."""
    recent: tuple[str, ...] = field(default=())
    """Paths of the files opened last, the newest first."""

    def for_document(self, before_px: tuple[int, int], after_px: tuple[int, int]) -> "Session":
        """Return the session for a document with another picture: nothing is selected, the brush is as large on it."""
        return replace(
            self,
            brush=self.brush.carried(before_px, after_px),
            selected=frozenset(),
            features=frozenset(),
            selected_corners=frozenset(),
            selected_curve=None,
            selected_knots=frozenset(),
            selected_vertices=frozenset(),
            suggestions=(),
            last_dab=None,
            hover=None,
            shown="result",
        )
