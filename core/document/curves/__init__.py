"""Pairs of curves: edited, simplified, brought onto edges."""
