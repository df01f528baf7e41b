"""From what particles did to a facet to how fast it wears."""
