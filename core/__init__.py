"""Numerics and data of Weft: solvers, synthesis and decomposition. Never sees a window.

Where to begin, by what is wanted:

- pictures: `load`, `load_mask`, `save` and `Image` of `imaging.images`
- a warp that keeps features, once: `mapping.warping.warp_grid`, with `grid.Grid`, `grid.find_features` and
  `warps.presets.make_warp`; many times on one grid and mask: `mapping.features.feature_mapping.FeatureMapping`
- texture regrown along moved curves: `retexture.job.retexture`, with `curves.bezier.Curve` and
  `curves.feature_curves.FeatureCurve`
- a patterned cloth taken apart: `overlay.decomposition.decompose`; a new texture in its folds:
  `overlay.composition.compose`, on a photo of any depth `overlay.compositing.lay_over`
- what the editor edits: `document.document.Document`; its file: `load_project` and `save_project` of `document.project`
- linear systems: `linalg.factor.Factor`, factored once and solved many times

Long work is a generator, which `progress.run` runs to its end. What a caller can mend is raised as `arrays.InputError`,
every fault that can be explained as its base `arrays.WeftError`. Conventions of coordinates and arrays are in `arrays`.
"""
