"""The editor and the command line."""

import os

# The sparse solver calls BLAS on many small blocks, for which its threads wait for one another longer than they work.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
