"""From labels to pixels: resampling, seams, Poisson blending (DPD sec. 3.4)."""
