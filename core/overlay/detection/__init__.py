"""The search for the lattice of a pattern [NRT sec. 3.1]."""
