"""The document, and what follows from it: its map, its retextured picture, its cloth, its file."""
