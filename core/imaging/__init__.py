"""Pictures in memory and on disk: reading, writing, colour, metadata."""
