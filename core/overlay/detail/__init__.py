"""What the detail keeps of the old pattern, found and taken out of it."""
