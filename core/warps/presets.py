"""The presets: one table of names and parameters, and the warp that each stands for.

The first fifteen are the shapes that artists know from other editors under these names. `bend`, `horizontal` and
`vertical` run from -100 to 100. A bend of 0 without distortion is the identity. No preset folds; a strong swirl does on
grids that are too coarse for it, under about ten cells to its radius.
"""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from core.arrays import Floats, InputError, Points
from core.warps import shapes
from core.warps.projective import CORNERS, distortion, perspective, project
from core.warps.shapes import Amount, Pair, Shape
from core.warps.warp import Warp


@dataclass(frozen=True)
class Parameter:
    """A number that a preset can be given."""

    name: str
    label: str
    low: float
    high: float
    default: float
    unit: str = "%"

    def checked(self, value: float) -> float:
        """Return `value`, or raise `InputError` if it is out of range."""
        if not self.low <= value <= self.high:
            raise InputError(f"{self.name} {value:g}: not from {self.low:g} to {self.high:g}")
        return float(value)


BEND = Parameter("bend", "Bend", -100, 100, 0)
HORIZONTAL = Parameter("horizontal", "Horizontal distortion", -100, 100, 0)
VERTICAL = Parameter("vertical", "Vertical distortion", -100, 100, 0)
_LEAST_BEND = 1e-9  # below it a radius would overflow


@dataclass(frozen=True)
class Preset:
    """A row of the table."""

    name: str
    label: str
    group: str
    shape: Shape
    settings: tuple[Parameter, ...] = ()
    """What it can be given beside bend, the distortions and the axis."""
    bends: bool = True
    """Whether the bend has a meaning."""


_WAVES = (Parameter("waves", "Waves", 0.5, 8, 1, ""),)
_DISC = (
    Parameter("center-x", "Centre across", 0, 100, 50),
    Parameter("center-y", "Centre down", 0, 100, 50),
    Parameter("radius", "Radius, of half the shorter side", 5, 400, 100),
)
_CORNERS = tuple(
    Parameter(f"{corner}-{axis}", f"{corner.replace('-', ' ').capitalize()} {axis}", -100, 100, 0)
    for corner in CORNERS
    for axis in "xy"
)
_SCALES = (Parameter("width", "Width", 5, 1000, 100), Parameter("height", "Height", 5, 1000, 100))

_ROWS = (
    Preset("none", "None", "Plain", shapes.stay, bends=False),
    Preset("arc", "Arc", "Arcs", shapes.arc),
    Preset("arc-lower", "Arc Lower", "Arcs", shapes.arc_lower),
    Preset("arc-upper", "Arc Upper", "Arcs", shapes.arc_upper),
    Preset("arch", "Arch", "Arches", shapes.arch),
    Preset("bulge", "Bulge", "Arches", shapes.bulge),
    Preset("shell-lower", "Shell Lower", "Arches", shapes.shell_lower),
    Preset("shell-upper", "Shell Upper", "Arches", shapes.shell_upper),
    Preset("flag", "Flag", "Waves", shapes.flag, _WAVES),
    Preset("wave", "Wave", "Waves", shapes.wave, _WAVES),
    Preset("fish", "Fish", "Waves", shapes.fish),
    Preset("rise", "Rise", "Waves", shapes.rise),
    Preset("fisheye", "Fisheye", "Lenses", shapes.fisheye),
    Preset("inflate", "Inflate", "Lenses", shapes.inflate),
    Preset("squeeze", "Squeeze", "Lenses", shapes.squeeze),
    Preset("twist", "Twist", "Lenses", shapes.twist),
    Preset("swirl", "Swirl", "More", shapes.swirl, _DISC),
    Preset("perspective", "Perspective", "More", perspective, _CORNERS),
    Preset("cylinder", "Cylinder", "More", shapes.cylinder),
    Preset("stretch", "Stretch", "More", shapes.stretch, _SCALES),
)
PRESETS: Mapping[str, Preset] = MappingProxyType({row.name: row for row in _ROWS})
"""Every preset by its name, in the order to list them in."""


def make_warp(
    name: str,
    width_px: int,
    height_px: int,
    *,
    bend: float = 0,
    horizontal: float = 0,
    vertical: float = 0,
    vertical_axis: bool = False,
    settings: Mapping[str, float] | None = None,
) -> Warp:
    """Return the preset `name` for a picture of `width_px` by `height_px`, points (..., 2) in pixels to pixels.

    `bend`, `horizontal` and `vertical` are per cent, -100 to 100; `vertical_axis` turns the shape by 90° clockwise, so
    that what went up goes to the right; `settings` are the preset's own parameters. Raises `InputError` for an unknown
    name and for values out of range.
    """
    if min(width_px, height_px) < 1:
        raise InputError(f"picture of {width_px}x{height_px}: must be at least 1x1")
    preset = _preset(name)
    values = _settings(preset, settings or {})
    bend, horizontal, vertical = BEND.checked(bend), HORIZONTAL.checked(horizontal), VERTICAL.checked(vertical)
    aspect = height_px / width_px if vertical_axis else width_px / height_px
    amount = Amount(bend / 100, aspect, values)
    bend = 0.0 if abs(bend) < _LEAST_BEND else bend
    still = bend == 0 and all(values[p.name] == p.default for p in preset.settings)
    shape = shapes.stay if still else preset.shape
    shape(np.zeros(1), np.zeros(1), amount)  # what the settings rule out is said now
    matrix = _distortion_of(shape, amount, horizontal / 100, vertical / 100, vertical_axis=vertical_axis)
    half = np.array([width_px, height_px]) / 2
    center = half - 0.5

    def warp(points: Points) -> Points:
        if shape is shapes.stay and matrix is None:
            return points.copy()
        unit = (points - center) / half
        s, t = _bent(shape, unit[..., 0], unit[..., 1], amount, vertical_axis=vertical_axis)
        if matrix is not None:
            s, t = project(matrix, s, t)
        return np.stack([s * half[0] + center[0], t * half[1] + center[1]], axis=-1)

    return warp


def _preset(name: str) -> Preset:
    """Return the row called `name`, or name those that are like it."""
    if name in PRESETS:
        return PRESETS[name]
    near = difflib.get_close_matches(name.lower(), PRESETS, n=3, cutoff=0.5)
    raise InputError(f"preset {name!r}: unknown; {'did you mean' if near else 'one of'} {', '.join(near or PRESETS)}")


def _settings(preset: Preset, given: Mapping[str, float]) -> Mapping[str, float]:
    """Return every setting of `preset`, those in `given` checked, the others at their defaults."""
    known = {p.name: p for p in preset.settings}
    for name in given:
        if name not in known:
            raise InputError(f"preset {preset.name}: has no setting {name!r}; it has {', '.join(known) or 'none'}")
    return {name: p.checked(given.get(name, p.default)) for name, p in known.items()}


def _bent(shape: Shape, s: Floats, t: Floats, amount: Amount, *, vertical_axis: bool) -> Pair:
    """Apply `shape`, turned by 90° clockwise for the vertical axis: its "up", t = -1, is then s = 1."""
    if not vertical_axis:
        return shape(s, t, amount)
    across, down = shape(t, -s, amount)
    return -down, across


def _distortion_of(
    shape: Shape, amount: Amount, horizontal: float, vertical: float, *, vertical_axis: bool
) -> Floats | None:
    """Return the projective matrix of the distortions on the box around the bent frame, or None without any.

    On that box, and not on the unit frame, its denominators are positive wherever the shape reaches.
    """
    if horizontal == 0 and vertical == 0:
        return None
    edge = np.linspace(-1, 1, 257)
    one = np.ones_like(edge)
    outline = np.concatenate([edge, edge, one, -one]), np.concatenate([one, -one, edge, edge])
    s, t = _bent(shape, *outline, amount, vertical_axis=vertical_axis)
    center = (s.min() + s.max()) / 2, (t.min() + t.max()) / 2
    half = (s.max() - s.min()) / 2, (t.max() - t.min()) / 2
    into = np.array([[1 / half[0], 0, -center[0] / half[0]], [0, 1 / half[1], -center[1] / half[1]], [0, 0, 1]])
    matrix: Floats = np.linalg.inv(into) @ distortion(horizontal, vertical) @ into
    return matrix
