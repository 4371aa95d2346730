"""Tools of Overlay mode."""
