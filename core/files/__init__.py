"""Files and folders: written whole or not at all, owned, swept, and read without trust."""
