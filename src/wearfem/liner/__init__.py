"""The worn solid: its mesh, its strength, and how its surface recedes. Knows no particles beyond `Surface` and `FacetLoads`."""
