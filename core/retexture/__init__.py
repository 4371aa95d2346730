"""Detail-preserving deformation [DPD]: regrow the texture along a moved curve."""
