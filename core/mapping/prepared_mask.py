"""The linear answer to W, by all that depends on a mask and the options alone and is kept while W changes."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from core.arrays import Points
from core.grid import Features
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.features.soft_features import SoftFeatures
from core.mapping.features.straight_lines import LineSolver, Pull
from core.mapping.handles.curved_frame import Cut, cuts_of, fit_cuts
from core.mapping.handles.frame_glide import FrameGlide
from core.mapping.handles.straight_frame import Placed, Rectangle, place_cut
from core.mapping.jacobians import as_complex
from core.mapping.options import DEFAULT_OPTIONS, MappingOptions
from core.mapping.stroke import MaskStroke


class PreparedMask:
    """The mapping of features, and how the frame of the picture meets them."""

    def __init__(self, mapping: FeatureMapping, options: MappingOptions, *, pull: Pull | None = None) -> None:
        self.mapping, self._options, self._pull = mapping, _of_features(options), pull

    def fits(self, features: Features, options: MappingOptions) -> bool:
        """Return whether it was prepared for just these features and options."""
        return self.mapping.features is features and self._options == _of_features(options)

    def fits_poses(self, options: MappingOptions) -> bool:
        """Return whether the options say the same about features, whatever lines are to stay straight."""
        return replace(self._options, lines=options.lines) == _of_features(options)

    @property
    def is_ready(self) -> bool:
        """Whether `refine` has nothing to prepare for straight lines."""
        return self._options.lines is None or "_lines" in vars(self)

    @property
    def pull(self) -> Pull | None:
        """What straightened the last answer, under this mask or the one before."""
        return self._lines.pull if self.is_ready and self._lines is not None else self._pull

    def sketch(self, found: Solution, plain: Points) -> Solution:
        """Return what `refine` does, with lines drawn at as they were under the mask before: nothing is prepared."""
        if self._soft is not None:
            found = self._soft.soften(found, as_complex(plain))
        return found if self._pull is None else self._pull.apply(self.mapping, found)

    def refine(self, found: Solution, plain: Points) -> Solution:
        """Return the answer for W at the nodes (R, C, 2) with soft features, and lines straight beside features."""
        if self._soft is not None:
            found = self._soft.soften(found, as_complex(plain))
        if self._lines is None:
            return found
        rectangle = Rectangle.of(as_complex(plain))
        glides = rectangle is not None and rectangle.stretches(self.mapping.grid)
        return self._lines.straighten(found, glides=glides)

    def answer(self, plain: Points, stroke: MaskStroke) -> Solution:
        """Return the linear answer without handles, which may fold, for W at the nodes (R, C, 2), before `refine`.

        Where W keeps the frame a rectangle, features that it cuts slide along its sides, and where it stretches the
        picture, all of the frame glides with what the features do; where W bends it, they fit between its nodes.
        """
        mapping, w = self.mapping, as_complex(plain)
        if not mapping.has_poses:
            stroke.forget()
            return mapping.place(w)
        rectangle = Rectangle.of(w)
        if rectangle is None:
            pose = stroke.pose(mapping, plain, Placed.none(mapping))
            return mapping.follow(pose, *fit_cuts(self._cuts, w, pose.alpha, pose.t))
        placed = place_cut(mapping, w, rectangle)
        if placed.frame is not None:
            cut = np.isin(mapping.index, np.flatnonzero(placed.bodies))
            if not rectangle.holds(placed.frame[cut]):
                stroke.forget()
                return rectangle.cover(mapping)
        found = mapping.follow(stroke.pose(mapping, plain, placed))
        if not rectangle.stretches(mapping.grid):
            return found
        stroke.forget()
        glided = replace(placed, frame=self._glide.glide(found.z, w))
        return mapping.follow(mapping.pose(w, glided.alpha, glided.t, moving=~glided.bodies, frame=glided.frame))

    @cached_property
    def _soft(self) -> SoftFeatures | None:
        return SoftFeatures(self.mapping) if self.mapping.soft else None

    @cached_property
    def _lines(self) -> LineSolver | None:
        lines = self._options.lines
        return None if lines is None else LineSolver(self.mapping, lines, self._options.weight)

    @cached_property
    def _glide(self) -> FrameGlide:
        return FrameGlide(self.mapping)

    @cached_property
    def _cuts(self) -> list[Cut]:
        return cuts_of(self.mapping)


def _of_features(options: MappingOptions) -> MappingOptions:
    """Return the options without what they say about handles alone."""
    return replace(options, frame=DEFAULT_OPTIONS.frame)
