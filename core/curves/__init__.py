"""Cubic Bezier curves: evaluation, editing, fitting, tracing, pairs of a curve and its target."""
