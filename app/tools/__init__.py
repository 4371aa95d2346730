"""Tools of the canvas, one file each; `all.TOOLS` lists them."""
