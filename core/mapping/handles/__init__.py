"""What the hand and the frame ask for: pins, inner curves, a straight frame  [FAT sec. 3]."""
