"""Graphs that more than one of the pipelines works with."""
