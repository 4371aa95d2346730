"""Panels beside the canvas, one per mode, and the lists in them."""
