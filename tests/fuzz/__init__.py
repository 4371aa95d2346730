"""Malformed files, made at random from good ones by what they are built of, for every reader of the program."""
