"""Which of several proposals is the cloth's pattern."""
