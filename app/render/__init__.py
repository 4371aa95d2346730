"""Drawing on the GPU: on screen, and to a file by the same shaders."""
