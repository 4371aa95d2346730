"""Linear systems on the grid: the Laplacian, its multifrontal factor, sine transforms, assembly."""
