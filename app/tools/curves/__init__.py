"""Tools that draw and edit curves."""
