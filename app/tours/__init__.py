"""Tours for those who begin: a sample for each mode, and a few steps that wait until each is done."""
