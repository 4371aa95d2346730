"""Light, pixel by pixel, where the model's shading cannot be trusted or is too coarse."""
