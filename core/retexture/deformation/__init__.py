"""The deformation by moved curves (DPD sec. 3.1) and coordinates along them (sec. 3.2)."""
