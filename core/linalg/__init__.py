"""Linear algebra: sparse Cholesky factors, fast sine transforms, Poisson's equation, threads of BLAS."""
