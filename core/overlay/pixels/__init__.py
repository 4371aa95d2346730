"""What holds at each pixel of the photo, where the mesh is too coarse or its model cannot be trusted."""
