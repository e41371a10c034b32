"""Every speed claim, side by side with a peer, in one run: `make bench`."""

import os

# one thread each: idle threads of OpenBLAS spin, which processor time counts twice
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
