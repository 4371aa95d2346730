"""Between the editor and the disk: opening, saving, exporting, masks."""
