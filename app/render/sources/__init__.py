"""What the canvas is drawn from: pictures, cloth and masks on the GPU."""
