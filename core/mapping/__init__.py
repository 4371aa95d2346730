"""Feature-aware mapping [FAT]: one constrained problem for features, handles, frame and folds.

A picture lies on a grid of R x C nodes. W takes node v_i to W(v_i): a preset, a new size, an outline. Sought is where
the nodes really go, z, complex, one number a node.

Unknown are the free nodes and the similarity (α_i, t_i) of every feature: its nodes lie at α_i p + t_i, p their rest
positions from their centroid. A feature is therefore exactly similar by construction; FAT's eq. 3 asks for it in the
least-squares sense only.

Minimised is, over quads with a weight w(Q) (FAT eqs. 6 and 7) and their four edges,

    ½ Σ |dz - dW|²  of the quads that follow W (FAT eq. 4)  +  ½ Σ w² |dz - α dp|²  of those around features (eq. 3),

together with what features ask for that are protected softly (`features.soft_features`), a soft term that keeps lines
straight, where there are any (`features.straight_lines`), a prior on sizes,
|α_i| = s_i, where s_i is λ_i of FAT sec. 2.1 within the limits of the feature (1 for rigid ones; `features.limits`),
and, where it would fold, a barrier that keeps the area of every corner of a quad positive.

Subject to

- the frame lies where W has it (FAT eq. 5). Where W keeps it a rectangle, its nodes glide along their side and only
  along it, and a feature that a side cuts does not turn (α real) and slides along it;
- α of a feature that stays upright is real;
- every handle holds (FAT eq. 8): a point of the background is, bilinearly, where the hand has it; a point in a feature
  fixes its place, two its place, turn and size, more do so in the least-squares sense. A ring around a point fixes the
  turn and size of what lies around it, of a feature or of the background (`handles.probes`).

Handles displace the picture that is there without them: one that is not moved changes nothing, to the last bit. Their
own W is that picture moved by a thin plate with rigid inclusions, whose local rotation is free.

When not everything can be had, this yields, in this order: the background; the sizes of features; the places that W
alone would give; handles, the farthest-fetched first. Never the shape of a feature, and nothing folds that W does not.

The rooms, each of which knows only those before it:

- `jacobians`, `folds`: linear parts of quads (FAT eqs. 1 and 2), signed areas of their corners
- `linear`: the normal equations (FAT eq. 10), their multifrontal factor (eq. 11) and substitutions (eqs. 12 and 13)
- `features`: the problem without handles and barrier; features are eliminated, so that the factor knows the mask only
- `handles`: what pins, curves and a straight frame ask for, and the linear answer to it
- `injective`: the barrier and its continuation, from a linear answer that folds to a map that does not
- `options`, `result`, `warper`, `warping`: what is chosen, what came of it; what an editor keeps from frame to frame,
  and the one call
"""
