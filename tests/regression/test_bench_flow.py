"""The flows that are timed are those of other codes, and the same bits on one thread and on two."""

import numpy as np
import pytest

from wearfem.benchmarks import BENCHMARKS
from wearfem.dem.sample import Stepper
from wearfem.jit import set_thread_count, thread_count
from wearfem.proofs import bench_flow

by_name = {benchmark.name: benchmark for benchmark in BENCHMARKS}


@pytest.mark.parametrize("name", ["bed_5000", "bed_20000"])
def test_contacts_in_a_settled_bed(name):
    claim = bench_flow.bed_claim(by_name[name])
    assert claim.holds, claim


@pytest.mark.slow
def test_contacts_in_the_large_bed():
    claim = bench_flow.bed_claim(by_name["bed_100000"])
    assert claim.holds, claim


def test_flow_down_the_plate():
    for claim in bench_flow.plate_claims():
        assert claim.holds, claim


@pytest.mark.parametrize("name", ["bed_5000", "plate"])
def test_same_bits_on_one_thread_and_on_two(name):
    before, results = thread_count(), []
    try:
        for threads in (1, 2):
            set_thread_count(threads)
            stepper = Stepper(*by_name[name].start())
            stepper.advance(100)
            results.append((stepper.particles, stepper.tally.sums, stepper.ledger))
    finally:
        set_thread_count(before)
    one, two = results
    for first, second in zip(one[0], two[0], strict=True):
        np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(one[1], two[1])
    np.testing.assert_array_equal(one[2], two[2])
