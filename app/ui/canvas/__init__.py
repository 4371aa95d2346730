"""The canvas: pointer and keys, the scene, and what is drawn over the picture."""
