"""How a liner wears under a flow of particles, and how long it will last."""

__version__ = "0.1.0.dev0"
