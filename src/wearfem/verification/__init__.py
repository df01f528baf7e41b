"""What the engine is measured against: published tests as data, and theory derived by another route.

Nothing here imports the engine; the engine does not import this package.
"""
