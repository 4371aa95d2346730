"""What the program keeps for itself on the disk: preferences, unsaved work, what a project's file was."""
