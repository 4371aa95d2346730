"""Tools that select: what they find is added to what is painted, replaces it, is cut out of it or crossed with it."""
