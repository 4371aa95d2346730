"""Selecting parts of a picture: masks (H, W) of grey levels, 255 where all of a pixel is selected."""
