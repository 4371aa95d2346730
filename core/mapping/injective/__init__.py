"""Removal of folds: injective maps of the grid under features, handles and the frame."""
