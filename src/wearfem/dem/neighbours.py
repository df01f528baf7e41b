"""Who may touch whom: particles sorted into cells, pairs listed with a margin, histories handed on.

Particles of different size live in grids of different cell size (a level for each factor of two in radius), so that a
size ratio of 10 costs little more than one size (Ogarko and Luding 2012). Each pair is found once: from the finer level, or
within a level from the half of the neighbouring cells that comes later.
"""

from typing import NamedTuple

import numpy as np

from wearfem.dem.contact import Contact
from wearfem.dem.pairs import PairList, memory_rows
from wearfem.jit import compiled, inlined, kernel, parallel, prange
from wearfem.vector import nearest

LEVELS = 8  # size ratios up to 2**8
CHUNK_PARTICLES = 2500  # about this many particles are one task of a thread
MOST_CHUNKS = 64


class Grid(NamedTuple):
    """Cells of every level; particles are sorted so that those of a cell lie side by side."""

    level: np.ndarray  # (n,) int8, level of a particle: 0 holds the largest
    cells: np.ndarray  # (levels, 3) int64, number of cells along each axis; 0 where a level is empty
    size: np.ndarray  # (levels, 3) [m]
    stride: np.ndarray  # (levels, 3) int64, from coordinates to cell number
    offset: np.ndarray  # (levels,) int64, number of a level's first cell
    origin: np.ndarray  # (3,) [m]
    start: np.ndarray  # (cells + 1,) int64, first particle of a cell
    slow: int  # axis along which cell numbers grow slowest
    middle: int
    fast: int


@compiled
def chunk_bounds(count):
    """First particle of each chunk, (chunks + 1,): a function of the number of particles only."""
    chunks = 1
    while chunks * CHUNK_PARTICLES * 3 // 2 < count and chunks < MOST_CHUNKS:
        chunks *= 2
    bounds = np.empty(chunks + 1, np.int64)
    for c in range(chunks + 1):
        bounds[c] = count * c // chunks
    return bounds


@kernel
def cell_of(grid, level, x, y, z):
    """Cell coordinates of a point on a level's grid, clipped to the grid."""
    cx = min(max(int((x - grid.origin[0]) / grid.size[level, 0]), 0), grid.cells[level, 0] - 1)
    cy = min(max(int((y - grid.origin[1]) / grid.size[level, 1]), 0), grid.cells[level, 1] - 1)
    cz = min(max(int((z - grid.origin[2]) / grid.size[level, 2]), 0), grid.cells[level, 2] - 1)
    return cx, cy, cz


def plan_grid(position, radius, low, period, skin) -> Grid:
    """Cells for these particles, not yet filled: as wide as the reach of a level, fewer where particles are sparse."""
    count = len(radius)
    level = np.minimum(np.log2(radius.max() / radius) + 1e-9, LEVELS - 1).astype(np.int8)
    origin = np.where(period > 0.0, low, position.min(axis=0))
    extent = np.where(period > 0.0, period, position.max(axis=0) - origin)
    slow, middle, fast = (int(axis) for axis in np.argsort(-extent, kind="stable"))
    cells, size = np.zeros((LEVELS, 3), np.int64), np.ones((LEVELS, 3))
    stride, offset = np.zeros((LEVELS, 3), np.int64), np.zeros(LEVELS, np.int64)
    total = 0
    for k in np.flatnonzero(np.bincount(level)):
        edge = 2.0 * radius[level == k].max() + skin
        while np.prod(np.floor(extent / edge) + 1.0) > 8.0 * count + 1000.0:
            edge *= 1.25
        number = np.floor(extent / edge)
        cells[k] = np.where(period > 0.0, np.maximum(number, 1), number + 1)
        size[k] = np.where(period > 0.0, extent / cells[k], edge)
        offset[k] = total
        stride[k, fast], stride[k, middle], stride[k, slow] = (
            1,
            cells[k, fast],
            cells[k, fast] * cells[k, middle],
        )
        total += int(np.prod(cells[k]))
    return Grid(level, cells, size, stride, offset, origin, np.zeros(total + 1, np.int64), slow, middle, fast)


@compiled
def fill_grid(grid, position):
    """Count particles into the cells of `grid`; returns the order (n,) that sorts them by cell: a stable counting sort."""
    count = len(position)
    key = np.empty(count, np.int64)
    for i in range(count):
        k = grid.level[i]
        cx, cy, cz = cell_of(grid, k, position[i, 0], position[i, 1], position[i, 2])
        key[i] = grid.offset[k] + cx * grid.stride[k, 0] + cy * grid.stride[k, 1] + cz * grid.stride[k, 2]
        grid.start[key[i] + 1] += 1
    for cell in range(len(grid.start) - 1):
        grid.start[cell + 1] += grid.start[cell]
    place = grid.start[:-1].copy()
    order = np.empty(count, np.int64)
    for i in range(count):
        order[place[key[i]]] = i
        place[key[i]] += 1
    return order


def sort_into_cells(position, radius, low, period, skin) -> tuple[Grid, np.ndarray]:
    """The filled grid, whose levels follow the new order, and the order (n,) that sorts particles into it."""
    grid = plan_grid(position, radius, low, period, skin)
    order = fill_grid(grid, position)
    return grid._replace(level=grid.level[order]), order


@inlined
def list_range(position, radius, i, begin, end, skin, period, found, most, second):
    """Append to `second` the particles of [begin, end) that are within reach of particle i; returns the new count.

    Without branches, which would not be foreseen; where there is no room the last place takes what comes.
    """
    x, y, z = position[i, 0], position[i, 1], position[i, 2]
    reach = radius[i] + skin
    lx, ly, lz = period[0], period[1], period[2]
    ix = 1.0 / lx if lx > 0.0 else 0.0
    iy = 1.0 / ly if ly > 0.0 else 0.0
    iz = 1.0 / lz if lz > 0.0 else 0.0
    for j in range(begin, end):
        dx, dy, dz = position[j, 0] - x, position[j, 1] - y, position[j, 2] - z
        dx -= lx * nearest(dx * ix)
        dy -= ly * nearest(dy * iy)
        dz -= lz * nearest(dz * iz)
        limit = reach + radius[j]
        second[min(found, most - 1)] = j
        found += 1 if dx * dx + dy * dy + dz * dz < limit * limit else 0
    return found


@kernel
def list_row(
    position, radius, grid, level, i, coordinate, da, db, from_own, skin, period, found, most, second
):
    """Search the row of cells at offset (da, db) on the slower axes; `from_own`: only what comes after particle i."""
    a, b, c = coordinate[grid.slow] + da, coordinate[grid.middle] + db, coordinate[grid.fast]
    if a < 0 or a >= grid.cells[level, grid.slow]:
        if period[grid.slow] == 0.0:
            return found
        a %= grid.cells[level, grid.slow]
    if b < 0 or b >= grid.cells[level, grid.middle]:
        if period[grid.middle] == 0.0:
            return found
        b %= grid.cells[level, grid.middle]
    row = grid.offset[level] + a * grid.stride[level, grid.slow] + b * grid.stride[level, grid.middle]
    last = grid.cells[level, grid.fast] - 1
    low, high = max(c - 1, 0), min(c + 1, last)
    begin = i + 1 if from_own else grid.start[row + low]
    found = list_range(
        position, radius, i, begin, grid.start[row + high + 1], skin, period, found, most, second
    )
    if period[grid.fast] > 0.0:
        if c == 0 and not from_own:
            begin, end = grid.start[row + last], grid.start[row + last + 1]
            found = list_range(position, radius, i, begin, end, skin, period, found, most, second)
        if c == last:
            begin, end = grid.start[row], grid.start[row + 1]
            found = list_range(position, radius, i, begin, end, skin, period, found, most, second)
    return found


@kernel
def list_chunk(position, radius, grid, bounds, chunk, capacity, skin, period, pairs, crossing):
    """List the pairs of one chunk's particles; `crossing[chunk]` counts partners elsewhere. Returns pairs found, listed or not."""
    low, high = bounds[chunk], bounds[chunk + 1]
    base = chunk * capacity
    second = pairs.second[base : base + capacity]
    found = 0
    crossing[chunk] = 0
    for i in range(low, high):
        before = found
        x, y, z = position[i, 0], position[i, 1], position[i, 2]
        for level in range(grid.level[i] + 1):
            if grid.cells[level, 0] == 0:
                continue
            coordinate = cell_of(grid, level, x, y, z)
            own = level == grid.level[i]
            for da in range(0 if own else -1, 2):
                for db in range(0 if own and da == 0 else -1, 2):
                    found = list_row(
                        position, radius, grid, level, i, coordinate, da, db, own and da == 0 and db == 0,
                        skin, period, found, capacity, second,
                    )  # fmt: skip
        pairs.row_start[i] = base + before
        pairs.row_count[i] = found - before
        for k in range(before, min(found, capacity)):
            pairs.first[base + k] = i
            j = second[k]
            if j < low or j >= high:
                pairs.slot[base + k] = crossing[chunk]
                crossing[chunk] += 1
            else:
                pairs.slot[base + k] = -1
    pairs.pair_end[chunk] = base + min(found, capacity)
    return found


@kernel
def hand_on_memory(force, rolling, twisting, bounds, chunk, order, old, new):
    """Copy to the new list what touching pairs remember; `order` says where each particle was in the old arrays."""
    rows, rolled = memory_rows(Contact(force, rolling, twisting)), rolling.memory_size()
    for i in range(bounds[chunk], bounds[chunk + 1]):
        was = order[i]
        for q in range(new.row_start[i], new.row_start[i] + new.row_count[i]):
            partner_was = order[new.second[q]]
            source, sign = -1, 1.0
            for k in range(old.row_start[was], old.row_start[was] + old.row_count[was]):
                if old.second[k] == partner_was:
                    source = k
            if source < 0:
                sign = -1.0
                for k in range(
                    old.row_start[partner_was], old.row_start[partner_was] + old.row_count[partner_was]
                ):
                    if old.second[k] == was:
                        source = k
            if source >= 0:
                for row in range(rows):
                    turns = row < 3 or (4 <= row < 4 + rolled)
                    new.memory[q, row] = old.memory[source, row] * (sign if turns else 1.0)


def empty_pairs(count, chunks, capacity, rows):
    """A list without pairs, with room for `capacity` in each chunk."""
    size = chunks * capacity
    return PairList(
        np.zeros(size, np.uint32),
        np.zeros(size, np.uint32),
        np.zeros((size, rows)),
        np.arange(chunks, dtype=np.int64) * capacity,
        np.arange(chunks, dtype=np.int64) * capacity,
        np.zeros(count, np.int64),
        np.zeros(count, np.int32),
        np.full(size, -1, np.int32),
        np.zeros((0, 6)),
        np.zeros(chunks + 1, np.int64),
        np.zeros((0, 2), np.int32),
    )


@compiled
def address_remote(pairs, bounds, crossing):
    """Number the partners that live elsewhere, and list for each chunk those that are its own."""
    chunks = len(bounds) - 1
    total = crossing.sum()
    remote, inbox = np.zeros((total, 6)), np.zeros((total, 2), np.int32)
    inbox_start = np.zeros(chunks + 1, np.int64)
    first_slot, owner = 0, np.empty(total, np.int32)
    target = np.empty(total, np.int32)
    for chunk in range(chunks):
        base = pairs.pair_start[chunk]
        for q in range(base, pairs.pair_end[chunk]):
            if pairs.slot[q] >= 0:
                pairs.slot[q] += first_slot
                j = pairs.second[q]
                home = np.searchsorted(bounds, j, side="right") - 1
                owner[pairs.slot[q]], target[pairs.slot[q]] = home, j
                inbox_start[home + 1] += 1
        first_slot += crossing[chunk]
    for chunk in range(chunks):
        inbox_start[chunk + 1] += inbox_start[chunk]
    place = inbox_start[:-1].copy()
    for slot in range(total):
        k = place[owner[slot]]
        inbox[k, 0], inbox[k, 1] = slot, target[slot]
        place[owner[slot]] += 1
    return PairList(
        pairs.first,
        pairs.second,
        pairs.memory,
        pairs.pair_start,
        pairs.pair_end,
        pairs.row_start,
        pairs.row_count,
        pairs.slot,
        remote,
        inbox_start,
        inbox,
    )


@parallel
def list_chunks(position, radius, grid, bounds, capacity, skin, period, pairs, crossing, found):
    """`list_chunk` for all chunks."""
    for chunk in prange(len(bounds) - 1):
        found[chunk] = list_chunk(
            position, radius, grid, bounds, np.int64(chunk), capacity, skin, period, pairs, crossing
        )


@parallel
def hand_on_memories(force, rolling, twisting, bounds, order, old, new):
    """`hand_on_memory` for all chunks."""
    for chunk in prange(len(bounds) - 1):
        hand_on_memory(force, rolling, twisting, bounds, np.int64(chunk), order, old, new)


def list_pairs(contact, position, radius, grid, bounds, order, old, skin, period):
    """The Verlet list of all chunks, with the memory of `old` handed on. Room is found by trying again with more."""
    chunks, laws = len(bounds) - 1, (contact.force, contact.rolling, contact.twisting)
    crossing, found = np.zeros(chunks, np.int64), np.zeros(chunks, np.int64)
    capacity = max(64, len(old.first) // chunks)
    while True:
        pairs = empty_pairs(len(radius), chunks, capacity, memory_rows(contact))
        if chunks == 1:  # no threads, and no code for them to compile
            found[0] = list_chunk(position, radius, grid, bounds, 0, capacity, skin, period, pairs, crossing)
        else:
            list_chunks(position, radius, grid, bounds, capacity, skin, period, pairs, crossing, found)
        if found.max() < capacity:  # the last place takes what comes, so it must not be one that counts
            break
        capacity = int(found.max() * 1.1) + 1
    if chunks == 1:
        hand_on_memory(*laws, bounds, 0, order, old, pairs)
        return pairs
    hand_on_memories(*laws, bounds, order, old, pairs)
    return address_remote(pairs, bounds, crossing)
