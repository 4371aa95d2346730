"""Tools of the canvas, one file each."""
