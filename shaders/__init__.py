"""GLSL sources, read by app.render.programs."""
