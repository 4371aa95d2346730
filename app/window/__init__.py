"""The window: GLFW, the frame loop, signals, and what is loaded late."""
