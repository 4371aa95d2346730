"""What panels and dialogs are built of."""
