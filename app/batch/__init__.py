"""Many pictures by one recipe: sequences, videos and folders, on this machine or on others.

A plan says which frames there are and cuts them into chunks, always at the same places; a chunk is done by one process,
from its own factorisation on; records say what is done. So the bytes do not depend on who does which chunk when.
"""
