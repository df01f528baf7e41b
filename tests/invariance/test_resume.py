"""A run that is killed, stopped or starved of its disk goes on to the same bits."""

import gc
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path

import pytest

from wearfem.case import load_any_case
from wearfem.cycle import cycle, first_state
from wearfem.history import cycles_of, read_cycle, read_history
from wearfem.life import live
from wearfem.proofs.cycle import differences, plate, restart

ROOT = Path(__file__).parents[2]
CASE = ROOT / "cases" / "wearing_plate"
WEARFEM = [sys.executable, "-m", "wearfem.cli"]
SHORT = ["--set", "cells=4", "--set", "jumps=20", "--quiet"]  # some 22 cycles of a tenth of a second


def begin(run, *settings):
    return [*WEARFEM, "run", str(CASE), "--out", str(run), *SHORT, *settings]


def resume(run):
    return [*WEARFEM, "resume", str(run), "--quiet"]


def start(command, **options):
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src"), "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options
    )


def finish(command, **options):
    process = start(command, **options)
    out, error = process.communicate(timeout=300)
    return process.returncode, out, error


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    """The run that nothing happens to."""
    run = tmp_path_factory.mktemp("unbroken") / "run"
    code, _, error = finish(begin(run))
    assert code == 0, error
    return run


def assert_same(one, other):
    """The same cycles, each the same to the bit."""
    load_any_case(CASE)  # its classes are in the files
    assert cycles_of(one) == cycles_of(other)
    for number in (1, cycles_of(one) // 2, cycles_of(one)):
        assert differences(read_cycle(one, number), read_cycle(other, number)) == 0
    assert (one / "figures.json").read_text() == (other / "figures.json").read_text()
    assert (one / "surface.vtkhdf.series").read_text() == (other / "surface.vtkhdf.series").read_text()
    assert sorted(p.name for p in one.rglob("*")) == sorted(
        p.name for p in other.rglob("*")
    )  # nothing left lying


def killed(run, kills, seed):
    """Begin a run and kill it so many times at random moments; the cycles that were whole at each kill."""
    moment = random.Random(seed)
    command, whole = begin(run), []
    while len(whole) < kills:
        process = start(command)
        process.stdout.readline()  # it is at work now
        time.sleep(moment.uniform(0.0, 1.0))
        process.kill()
        code = process.wait()
        process.stdout.close(), process.stderr.close()
        if code != -signal.SIGKILL:
            return whole  # it was done before
        whole.append(cycles_of(run))
        command = resume(run)
    return whole


def test_a_kill_between_the_last_cycle_and_the_list_of_faces_loses_nothing(unbroken, tmp_path):
    run, series = tmp_path / "run", "surface.vtkhdf.series"
    shutil.copytree(unbroken, run)
    (run / series).unlink()
    live(load_any_case(CASE, {"cells": 4, "jumps": 20}), run, quiet=True)
    assert (run / series).read_text() == (unbroken / series).read_text()


def test_five_kills(unbroken, tmp_path):
    whole = killed(tmp_path / "run", 5, seed=1)
    assert whole == sorted(whole)  # no kill takes a cycle away
    code, _, error = finish(resume(tmp_path / "run"))
    assert code in (0, 2), error  # 2: it was finished between the last two kills
    assert_same(unbroken, tmp_path / "run")


@pytest.mark.slow
def test_fifty_kills(unbroken, tmp_path):
    kills, number = 0, 0
    while kills < 50:
        run = tmp_path / f"run{number}"
        whole = killed(run, 50 - kills, seed=1000 + number)
        assert whole == sorted(whole)
        kills, number = kills + len(whole), number + 1
        finish(resume(run))
        assert_same(unbroken, run)


def test_a_state_that_is_written_and_read_lives_on_the_same():
    claim = restart()
    assert claim.holds, claim


def test_ctrl_c_ends_the_cycle_and_says_how_to_go_on(unbroken, tmp_path):
    run = tmp_path / "run"
    process = start(begin(run))
    process.stdout.readline()
    while not cycles_of(run):
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert f"stopped after cycle {cycles_of(run)}; go on with: wearfem resume {run}" in out
    assert "what was written so far is whole" in error
    assert finish(resume(run))[0] == 0
    assert_same(unbroken, run)


def test_a_full_disk_is_a_sentence_and_the_last_cycle_stays(unbroken, tmp_path):
    """No file may grow larger than a cycle's half way."""
    run = tmp_path / "run"

    def small(size):
        return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    sizes = [(unbroken / "cycles" / f"{number:04d}.h5").stat().st_size for number in (1, 16)]
    assert sizes[0] < sizes[1]  # states name more samples as life goes on
    code, _, error = finish(begin(run), preexec_fn=small(sum(sizes) // 2))
    assert code == 2
    assert error.startswith("wearfem: cannot write ") and "make room" in error and error.count("\n") == 1
    whole = cycles_of(run)
    assert 0 < whole < 16
    read_history(run)  # all of it can be read
    assert finish(resume(run))[0] == 0
    assert_same(unbroken, run)


@pytest.mark.skipif(os.getuid() == 0 and not shutil.which("setpriv"), reason="root may write anywhere")
def test_a_folder_that_became_read_only_is_a_sentence_and_the_last_cycle_stays(unbroken):
    place = Path(tempfile.mkdtemp())  # not pytest's, which others may not enter
    try:
        run = place / "run"
        shutil.copytree(unbroken, run)
        for number in range(4, cycles_of(unbroken) + 1):
            (run / "cycles" / f"{number:04d}.h5").unlink()
        manifest = (run / "manifest.json").read_text()
        finished = manifest[manifest.index('"finished"') :].split("\n")[0]
        (run / "manifest.json").write_text(manifest.replace(finished, '"finished": null,'))
        for folder in (place, run, run / "cycles", run / "samples"):
            folder.chmod(0o555)
        humble = (
            ["setpriv", "--bounding-set=-dac_override"] if os.getuid() == 0 else []
        )  # root may write anywhere
        code, _, error = finish([*humble, *resume(run)])
        assert code == 2, error
        assert "cannot write" in error and "Permission denied" in error and "Traceback" not in error
        assert cycles_of(run) == 3
        read_history(run)
    finally:
        for folder in (place, *place.glob("run"), *place.glob("run/*/")):
            folder.chmod(0o755)
        shutil.rmtree(place)


@pytest.mark.slow
def test_particles_go_on_to_the_same_bits(tmp_path):
    """Killed in its third cycle, by real particles over a plate that sinks."""
    settings = [
        "--set",
        "loads=particles",
        "--set",
        "law=constant",
        "--set",
        "tolerance=0.1",
        "--set",
        "stop=2.4e6",
    ]
    begun = [*WEARFEM, "run", str(CASE), "--quiet", *settings]
    assert finish([*begun, "--out", str(tmp_path / "whole")])[0] == 0
    process = start([*begun, "--out", str(tmp_path / "run")])
    while cycles_of(tmp_path / "run") < 2:
        time.sleep(0.1)
    process.kill()
    process.communicate()
    assert finish(resume(tmp_path / "run"))[0] == 0
    assert_same(tmp_path / "whole", tmp_path / "run")


@pytest.mark.slow
def test_memory_stays_flat_over_200_cycles():
    """What grows are the rates of the samples, which the controller weighs anew each cycle, and nothing else."""
    case, _ = plate(law="constant", tolerance=1e-3, noise=0.02, delay=0.0, cells=8, jumps=200)
    state, used = first_state(case), {}
    tracemalloc.start()
    try:
        while state.cycle < 200:
            state, _ = cycle(case, state)
            if state.cycle in (20, 200):
                gc.collect()
                rates = sum(sample.rate.nbytes for sample in state.now.samples)
                used[state.cycle] = tracemalloc.get_traced_memory()[0] - rates
    finally:
        tracemalloc.stop()
    # a cycle leaves the depth, the mean, the error and the squares of its sample by facet, and 2 kB of objects and lag products
    assert used[200] - used[20] < 180 * (4 * 64 * 8 + 2048)  # [B]
