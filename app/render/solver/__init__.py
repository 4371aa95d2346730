"""The mapping's linear system on the GPU: conjugate gradients, preconditioned by multigrid, in compute shaders."""
