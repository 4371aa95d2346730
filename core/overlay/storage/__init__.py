"""What was found as files and pictures."""
