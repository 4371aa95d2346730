"""A feature-aware warp from W to its report, in one call: what the command line, the editor and Python share."""

from core.arrays import Points
from core.grid import Features, Grid
from core.mapping.handles.handles import Handles
from core.mapping.options import DEFAULT_OPTIONS, MappingOptions
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.progress import Job, run


def warp_grid(
    grid: Grid,
    features: Features,
    plain: Points,
    *,
    options: MappingOptions = DEFAULT_OPTIONS,
    handles: Handles | None = None,
    allow_folds: bool = False,
) -> Warped:
    """Map a grid as close to W as its features and handles allow, without folds where W has none.

    `plain` (R, C, 2) is where W takes the grid's nodes.
    """
    return run(warp_job(grid, features, plain, options=options, handles=handles, allow_folds=allow_folds))


def warp_job(
    grid: Grid,
    features: Features,
    plain: Points,
    *,
    options: MappingOptions = DEFAULT_OPTIONS,
    handles: Handles | None = None,
    allow_folds: bool = False,
) -> Job[Warped]:
    """Do what `warp_grid` does, step by step; a step's preview is a first (R, C, 2) without folds."""
    warper = Warper(grid)
    warper.use(features, options)
    if not allow_folds:
        return (yield from warper.settle(plain, handles))
    return warper.frame(plain, handles)
