"""What follows the document frame by frame."""
