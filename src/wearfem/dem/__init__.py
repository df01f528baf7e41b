"""Discrete elements: particles in, loads on the facets out. Knows no liner, no wear, no case."""
