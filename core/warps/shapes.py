"""The shapes behind the presets, as formulas on the unit frame.

A shape takes s and t, which run from -1 to 1 over the picture (s to the right, t down), and an `Amount`, and returns
where they go. `b` is the bend, -1 to 1; at 0 each shape is the identity. The aspect A is width over height, for the
shapes that speak of circles. None of them folds anywhere in its range; the reason is given with each: det is the
determinant of the Jacobian of (s, t).
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from core.arrays import Floats

Pair: TypeAlias = tuple[Floats, Floats]


@dataclass(frozen=True)
class Amount:
    """How strongly to bend, on what frame."""

    bend: float
    """b, -1 to 1."""
    aspect: float
    """A, width over height."""
    settings: Mapping[str, float] = field(default_factory=dict)
    """Every parameter of the preset itself, by name."""


Shape: TypeAlias = Callable[[Floats, Floats, Amount], Pair]


def bow(s: Floats) -> Floats:
    """Return 1 - s²: the curve of a cubic Bézier side whose two handles are raised alike."""
    return 1 - s * s


def stay(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Stay."""
    return s, t


def arc(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Bend the frame into a sector of a ring; at 1 it spans a half circle, arched upwards.

    The sector has the central angle q = pi |b| and the mean radius R. With half the height as the unit, R = 2A/q keeps
    the length of the middle line, and R > 1.5 keeps the inner edge at more than a fifth of the outer one's radius:
    R = sqrt((2A/q)² + 1.5²) does both in the limit. All is scaled by k = sqrt(2A / (q R)), so that the sector has the
    area of the frame.
    det = k² (R - t) q / 2 / A > 0.
    """
    side = math.copysign(1.0, amount.bend)
    angle = math.pi * abs(amount.bend)
    flat_radius = 2 * amount.aspect / angle
    radius = math.hypot(flat_radius, 1.5)
    scale = math.sqrt(flat_radius / radius)
    turn = (angle / 2) * s
    across = scale / amount.aspect * (radius - side * t) * np.sin(turn)
    # radius - (radius - t) cos(turn), written so that a large radius takes no digits away.
    return across, scale * (t * np.cos(turn) + side * 2 * radius * np.square(np.sin(turn / 2)))


def arc_lower(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Bow the lower side down, the upper stays straight; det = 1 + b bow(s) / 2 >= 1/2."""
    return s, t + amount.bend * bow(s) * (t + 1) / 2


def arc_upper(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Bow the upper side up, the lower stays straight; det = 1 + b bow(s) / 2 >= 1/2."""
    return s, t + amount.bend * bow(s) * (t - 1) / 2


def arch(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Raise the middle, upright lines stay upright; det = 1."""
    return s, t - 0.75 * amount.bend * bow(s)


def bulge(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Bow the upper side up and the lower side down; det = 1 + b bow(s) / 2 >= 1/2."""
    return s, t * (1 + 0.5 * amount.bend * bow(s))


def shell_lower(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Open the lower half like a fan, the upper side stays.

    With v = (t + 1) / 2: s' = s (1 + 0.4 b v²), t' = t + 0.6 b v² bow(s);
    det = (1 + 0.4 b v²)(1 + 0.6 b v bow(s)) + 0.48 b² v³ s² > 0.
    """
    opening = amount.bend * ((t + 1) / 2) ** 2
    return s * (1 + 0.4 * opening), t + 0.6 * opening * bow(s)


def shell_upper(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Open the upper half like a fan, the lower side stays: `shell_lower` upside down."""
    across, down = shell_lower(s, -t, amount)
    return across, -down


def flag(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Let the whole frame wave, upright lines stay upright; det = 1."""
    return s, t + 0.5 * amount.bend * np.sin((math.pi * amount.settings["waves"]) * s)


def wave(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Let the inside wave between straight sides; det = 1 - 0.8 b t sin >= 0.2."""
    return s, t + 0.4 * amount.bend * np.sin((math.pi * amount.settings["waves"]) * s) * bow(t)


def fish(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Swell to a body on the left and narrow to a tail on the right; det = 1 - 0.6 b sin >= 0.4."""
    return s, t * (1 - 0.6 * amount.bend * np.sin(math.pi * s))


def rise(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Climb from the left to the right, level at both ends; det = 1."""
    return s, t - 0.75 * amount.bend * np.sin((math.pi / 2) * s)


def fisheye(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Magnify the centre by 1.75^b inside a frame that stays.

    p' = p (1 + k) / (1 + k q) with q = s² + t² - s² t², which is 1 on the whole outline, and k = 1.75^b - 1. Along each
    ray from the centre the reach grows as 1 - k (s² + t² - 3 s² t²) > 0, since the bracket is in [-1, 1] and |k| < 1.
    """
    k = 1.75**amount.bend - 1
    q = 1 - bow(s) * bow(t)
    zoom = (1 + k) / (1 + k * q)
    return s * zoom, t * zoom


def inflate(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Bow all four sides outwards, corners stay.

    det = (1 + a bow(t))(1 + a bow(s)) - 4 a² s² t² with a = 0.4 b: at least 1 - 4 a² = 0.36, in the corners.
    """
    a = 0.4 * amount.bend
    return s * (1 + a * bow(t)), t * (1 + a * bow(s))


def squeeze(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Press left and right together, so that the upper and the lower side give way.

    det = (1 - a bow(t))(1 + a bow(s)) + 4 a² s² t² > 0 with a = b / 2.
    """
    a = 0.5 * amount.bend
    return s * (1 - a * bow(t)), t * (1 + a * bow(s))


def twist(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Turn the inside clockwise by up to 120 degrees in a frame that stays.

    The angle f = 2 pi/3 b bow(s)² bow(t)². A turn by an angle that varies from place to place has
    det = 1 + df/d(polar angle); here that derivative is at most 0.18 times the largest angle, 0.38.
    """
    angle = (2 * math.pi / 3 * amount.bend) * np.square(np.maximum(bow(s), 0) * np.maximum(bow(t), 0))
    return _turn(s, t, angle)


def swirl(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Turn a disc clockwise by up to 180 degrees at its centre; round on any frame.

    The angle pi b (1 - r²)², r being the distance in radii, is the same along every circle: det = 1.
    """
    at_x, at_y, radius = (amount.settings[name] / 50 for name in ("center-x", "center-y", "radius"))
    # Half the shorter side is the unit: on a wide frame it is half the height.
    across, down = max(amount.aspect, 1.0), max(1 / amount.aspect, 1.0)
    x, y = (s + 1 - at_x) * across, (t + 1 - at_y) * down
    inside = np.maximum(1 - (x * x + y * y) * (4 / radius**2), 0)
    x, y = _turn(x, y, (math.pi * amount.bend) * inside * inside)
    return x / across - 1 + at_x, y / down - 1 + at_y


def cylinder(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Paste the picture on an upright cylinder that is seen from the front; below 0 on the inside of one.

    The picture spans the angle +-f, f = 75° |b|, of a cylinder of radius R = A / f; the eye is at the distance
    D = 4 max(A, 1), half the height being the unit. s' depends on s alone and grows while cos f > R / (R + D), which
    R <= D / (4 f) ensures; det = ds'/ds * D / (D + depth) > 0. The middle keeps its height, the ends their width.
    """
    reach = math.radians(75) * abs(amount.bend)
    radius, distance = amount.aspect / reach, 4 * max(amount.aspect, 1.0)
    side = math.copysign(radius, amount.bend)

    def seen(angle: Floats) -> Pair:
        nearness = distance / (distance + side * 2 * np.square(np.sin(angle / 2)))
        return radius * np.sin(angle) * nearness, nearness

    width, _ = seen(np.array(reach))
    across, nearness = seen(reach * s)
    return across / width, t * nearness


def stretch(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Scale width and height; bending doubles or halves the width on top."""
    width, height = amount.settings["width"] / 100 * 2**amount.bend, amount.settings["height"] / 100
    return s * width, t * height


def _turn(x: Floats, y: Floats, angle: Floats) -> Pair:
    """Return (x, y) turned by `angle`; with y down a positive angle is clockwise."""
    sine, cosine = np.sin(angle), np.cos(angle)
    return cosine * x - sine * y, sine * x + cosine * y
