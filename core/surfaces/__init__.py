"""Surfaces in space that a picture is laid on: shapes by name, meshes from files, and their conformal charts."""
