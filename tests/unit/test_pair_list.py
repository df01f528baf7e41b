"""The list of pairs against all pairs, whatever room it finds."""

import numpy as np
import pytest

from wearfem.dem.contact import Contact, HertzMindlin
from wearfem.dem.neighbours import chunk_bounds, empty_pairs, list_pairs, sort_into_cells
from wearfem.dem.pairs import memory_rows

SKIN = 2e-3
NOT_PERIODIC = np.zeros(3)


@pytest.fixture(scope="module")
def packing():
    """Positions (n, 3) and radii (n,) [m] in the order of the grid, and the grid."""
    random = np.random.default_rng(3)
    position, radius = random.random((300, 3)) * 0.05, 1.5e-3 + 2.5e-3 * random.random(300)
    grid, order = sort_into_cells(position, radius, np.zeros(3), NOT_PERIODIC, SKIN)
    return position[order], radius[order], grid


def listed(packing, room):
    """Pairs that are listed where an old list had this much room."""
    position, radius, grid = packing
    contact, bounds = Contact(HertzMindlin()), chunk_bounds(len(radius))
    old = empty_pairs(len(radius), 1, room, memory_rows(contact))
    pairs = list_pairs(
        contact, position, radius, grid, bounds, np.arange(len(radius)), old, SKIN, NOT_PERIODIC
    )
    used = slice(pairs.pair_start[0], pairs.pair_end[0])
    return {
        tuple(sorted(pair))
        for pair in zip(pairs.first[used].tolist(), pairs.second[used].tolist(), strict=True)
    }


def test_all_pairs_are_listed_even_where_the_list_just_fits(packing):
    position, radius, _ = packing
    apart = np.linalg.norm(position[:, None] - position[None], axis=2)
    i, j = np.nonzero(np.triu(apart < radius[:, None] + radius[None] + SKIN, k=1))
    expected = set(zip(i.tolist(), j.tolist(), strict=True))
    assert len(expected) > 64  # more than the least room
    for room in (0, len(expected) - 1, len(expected), len(expected) + 1, 2 * len(expected)):
        assert listed(packing, room) == expected, f"room for {room} of {len(expected)}"
