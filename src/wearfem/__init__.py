"""How a liner wears under a flow of particles, and how long it will last."""

import os

# Before NumPy is loaded. Matrices here are small: threads of BLAS cost more than they gain, on busy cores thirty times, and change last
# bits.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0.dev0"
