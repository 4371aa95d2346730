"""Feature-aware mapping [FAT]: keep the shape of features under any warp."""
