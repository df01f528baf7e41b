"""`wearfem bench`: how fast the particles move here, beside other codes in the same sitting.

Machines drift: speeds of different minutes do not compare. So each round times wearfem and each peer one after the other, the
ratio is taken within the round, and medians over the rounds are shown. Nothing is asserted.
"""

import platform
import resource
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from wearfem import __version__
from wearfem.benchmarks import BENCHMARKS, Benchmark
from wearfem.benchmarks.peers import PEERS, Peer
from wearfem.dem.energy import touching_pairs
from wearfem.dem.flow import Flow, Model
from wearfem.dem.neighbours import chunk_bounds
from wearfem.dem.pairs import LANES, ROWS, pair_forces
from wearfem.dem.sample import Stepper
from wearfem.dem.steps import WORK, _finish_and_begin
from wearfem.dem.walls import new_scratch, wall_forces
from wearfem.errors import UserError, in_words
from wearfem.jit import most_threads, set_thread_count, thread_count
from wearfem.record import require_writable, write_json

ROUNDS = 3
REPEATS = 20  # of each phase
QUICK = ("bed_5000", "plate")


def bench(names: Sequence[str] = (), json_file: Path | None = None, quick: bool = False) -> dict[str, Any]:
    """Time the benchmarks, all or those named, print the figures and write them to a file.

    Parameters
    ----------
    names
        Of `BENCHMARKS`; all if there are none (the two short ones if `quick`).
    json_file
        Where else to write the figures.
    quick
        One round of a quarter of the steps.
    """
    known = {benchmark.name: benchmark for benchmark in BENCHMARKS}
    for name in names:
        if name not in known:
            raise UserError(f"there is no benchmark {name}: name {in_words(list(known), 'or')}")
    if json_file:
        require_writable(json_file)
    names = tuple(names) or (QUICK if quick else tuple(known))
    report: dict[str, Any] = {"wearfem": __version__, "machine": _machine(), "benchmarks": []}
    print(f"wearfem {__version__} on {report['machine']}", flush=True)
    before = thread_count()
    try:
        for name in names:
            figures = _measure(known[name], quick)
            report["benchmarks"].append(figures)
            print("\n".join(lines(figures)), flush=True)
    finally:
        set_thread_count(before)
    if json_file:
        write_json(json_file, report)
    return report


def _measure(benchmark: Benchmark, quick: bool) -> dict[str, Any]:
    """All figures of one benchmark."""
    rounds, steps = (1, benchmark.steps // 4) if quick else (ROUNDS, benchmark.steps)
    threads = sorted({1, min(2, most_threads())})
    flow, model = benchmark.start()
    began = time.perf_counter()
    Stepper(flow, model).advance(1)
    ready = time.perf_counter() - began
    warm = _advanced(flow, model, benchmark.warm)
    with TemporaryDirectory() as name:
        folder = Path(name)
        benchmark.write_inputs(folder)
        peers, skipped = _present(benchmark, folder, threads[-1], steps)
        speed: dict[str, dict[int, list[float]]] = {}
        for _ in range(rounds):
            for count in threads:
                for peer, skin in peers:
                    value = peer.speed(benchmark, folder, count, skin, benchmark.warm, steps)
                    if isinstance(value, float):
                        speed.setdefault(peer.name, {}).setdefault(count, []).append(value)
                    elif value not in skipped:
                        skipped.append(value)
                value = _speed(warm, model, steps, count)
                speed.setdefault("wearfem", {}).setdefault(count, []).append(value)
    return {
        "name": benchmark.name,
        "text": benchmark.text,
        "particles": warm.particles.count,
        "steps": steps,
        "rounds": rounds,
        "contacts_per_particle": 2.0 * len(touching_pairs(warm)) / warm.particles.count,
        "first_step_s": ready,
        "speed": {code: {str(c): median(v) for c, v in by.items()} for code, by in speed.items()},
        "ratio": {
            peer.name: {
                str(count): [
                    ours / theirs for ours, theirs in zip(speed["wearfem"][count], values, strict=True)
                ]
                for count, values in speed.get(peer.name, {}).items()
                if len(values) == rounds
            }
            for peer, _ in peers
        },
        "peer_skin_m": {peer.name: skin for peer, skin in peers},
        "skipped": skipped,
        "phase_ns": _phases(warm, model, steps),
        "memory": _memory(warm, model),
    }


def _present(
    benchmark: Benchmark, folder: Path, ranks: int, steps: int
) -> tuple[list[tuple[Peer, float]], list[str]]:
    """The peers that run here, each with its best skin of those to try; and a sentence for each that does not."""
    present, skipped = [], []
    for peer in PEERS:
        best, best_skin, sentence = 0.0, 0.0, ""
        skins = benchmark.peer_skins
        for skin in skins:
            warm, short = (benchmark.warm, steps // 2) if len(skins) > 1 else (1, 1)
            value = peer.speed(benchmark, folder, ranks, skin, warm, short)
            if isinstance(value, str):
                sentence = value
                break
            if value > best:
                best, best_skin = value, skin
        if sentence:
            skipped.append(sentence)
        else:
            present.append((peer, best_skin))
    return present, skipped


def _advanced(flow: Flow, model: Model, steps: int) -> Flow:
    set_thread_count(most_threads())
    stepper = Stepper(flow, model)
    stepper.advance(steps)
    return stepper.result()


def _speed(flow: Flow, model: Model, steps: int, threads: int) -> float:
    """Particle-steps per second of wearfem."""
    set_thread_count(threads)
    stepper = Stepper(flow, model)
    began = time.perf_counter()
    stepper.advance(steps)
    return flow.particles.count * steps / (time.perf_counter() - began)


def _phases(flow: Flow, model: Model, steps: int) -> dict[str, float]:
    """What a particle-step spends on one thread [ns], by phase; `lists` includes all that is done in Python."""
    set_thread_count(1)
    stepper = Stepper(flow, model)
    with _listing_timed(stepper) as listed:
        began = time.perf_counter()
        stepper.advance(steps)
        whole = time.perf_counter() - began
    whole, listing = whole / steps, sum(seconds for _, seconds in listed) / steps
    p, constants = stepper.particles, stepper.constants
    bounds = chunk_bounds(p.count)
    chunks = [np.int64(chunk) for chunk in range(len(bounds) - 1)]
    buffers, kinds = np.zeros((len(chunks), ROWS * LANES)), np.full((len(chunks), LANES), -1.0)
    lanes = np.zeros((len(chunks), 2 * LANES), np.uint32)
    buffers[:, : 21 * LANES] = 1.0
    work, pose, scratch = np.zeros((len(chunks), WORK)), stepper.pose(), new_scratch()

    def pair_phase() -> None:
        for chunk in chunks:
            pair_forces(
                model.contact, model.table, stepper.packed, p.wrench, stepper.pairs, chunk, buffers[chunk], kinds[chunk],
                lanes[chunk], constants.period, constants.time_step,
            )  # fmt: skip

    def wall_phase() -> None:
        for chunk in chunks:
            wall_forces(
                model.contact, model.tally, model.table, stepper.geometry, pose, stepper.packed, p.wrench, stepper.walls,
                stepper.tally, chunk, scratch, work, constants.time_step,
            )  # fmt: skip
        stepper.tally.filled[:] = 0

    def move_phase() -> None:
        p.wrench[:] = 0.0
        for chunk in chunks:
            _finish_and_begin(
                p, stepper.packed, stepper.pairs, stepper.drift, constants, work, bounds, chunk, True, True
            )

    phases = {
        "pairs": _shortest(pair_phase),
        "walls": _shortest(wall_phase),
        "move": _shortest(move_phase),
        "lists": listing,
    }
    phases["other"] = max(whole - sum(phases.values()), 0.0)
    return {name: 1e9 * seconds / p.count for name, seconds in phases.items()} | {
        "pair_lists_per_100_steps": 100.0 * sum(name == "list_again" for name, _ in listed) / steps,
        "wall_lists_per_100_steps": 100.0 * len(listed) / steps,  # walls are listed with pairs, too
    }


@contextmanager
def _listing_timed(stepper: Stepper) -> Iterator[list[tuple[str, float]]]:
    """Collects the name and seconds of each call that makes lists; calls within such a call are part of it."""
    taken: list[tuple[str, float]] = []
    inside = False

    def timed(method: Callable[..., None]) -> Callable[..., None]:
        def call(*arguments: Any) -> None:
            nonlocal inside
            if inside:
                return method(*arguments)
            inside, began = True, time.perf_counter()
            method(*arguments)
            taken.append((method.__name__, time.perf_counter() - began))
            inside = False

        return call

    names = ("list_again", "list_walls_again")
    for name in names:
        setattr(stepper, name, timed(getattr(stepper, name)))
    yield taken
    for name in names:
        delattr(stepper, name)


def _shortest(phase: Callable[[], None]) -> float:
    """Median time of a phase [s]."""
    phase()
    taken = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        phase()
        taken.append(time.perf_counter() - began)
    return median(taken)


def _memory(flow: Flow, model: Model) -> dict[str, float]:
    """Bytes of the arrays that a flow is made of, and the largest memory of this process so far."""
    pairs, walls = flow.pairs, flow.walls
    assert pairs is not None and walls is not None and flow.packed is not None
    count, listed = flow.particles.count, int(pairs.row_count.sum())
    own: list[np.ndarray | None] = [*flow.particles, flow.packed, flow.pair_reference, flow.wall_reference]
    own += [pairs.row_start, pairs.row_count, walls.row_of]
    by_pair = (pairs.first, pairs.second, pairs.memory, pairs.slot, pairs.remote, pairs.inbox)
    by_row = (walls.particle, walls.candidate_start, walls.candidate, walls.body, walls.record)
    touching = max(len(touching_pairs(flow)), 1)
    return {
        "bytes_per_particle": sum(array.nbytes for array in own if array is not None) / count,
        "bytes_per_listed_pair": sum(array.nbytes for array in by_pair) / max(listed, 1),
        "bytes_per_contact": sum(array.nbytes for array in by_pair) / touching,
        "bytes_per_particle_near_walls": sum(array.nbytes for array in by_row) / max(len(walls.particle), 1),
        "bytes_in_all_per_particle": sum(a.nbytes for a in (*own, *by_pair, *by_row) if a is not None)
        / count,
        "peak_process_bytes": 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
    }


def _machine() -> str:
    """The processor in words."""
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{model}, {most_threads()} cores, {platform.system()}"


def lines(figures: dict[str, Any]) -> list[str]:
    """The figures of one benchmark as lines of text."""
    memory, phase = figures["memory"], dict(figures["phase_ns"])
    pair_lists, wall_lists = phase.pop("pair_lists_per_100_steps"), phase.pop("wall_lists_per_100_steps")
    whole = sum(phase.values())
    text = [
        "",
        f"{figures['name']}: {figures['text']}; {figures['steps']} steps, {figures['rounds']} rounds, "
        f"{figures['contacts_per_particle']:.2f} contacts a particle",
    ]
    for code, speed in figures["speed"].items():
        said = [f"{1e-6 * value:7.2f} on {count}" for count, value in speed.items()]
        ratio = figures["ratio"].get(code, {})
        against = [
            f"{median(values):.2f} ({min(values):.2f}-{max(values):.2f}) on {count}"
            for count, values in ratio.items()
        ]
        skin = figures["peer_skin_m"].get(code)
        text.append(
            f"  {code:9s}{', '.join(said)} threads [million particle-steps/s]"
            + (f"; skin {1e3 * skin:g} mm" if skin else "")
            + (f"; wearfem is {', '.join(against)} times as fast" if against else "")
        )
    text += [f"  {sentence}" for sentence in figures["skipped"]]
    shares = [f"{name} {value:.1f} ns ({100 * value / whole:.0f} %)" for name, value in phase.items()]
    text += [
        f"  phases on 1 thread, a particle-step: {', '.join(shares)}; pairs are listed {pair_lists:.1f} times in 100 steps, "
        f"walls {wall_lists:.1f}",
        f"  memory: {memory['bytes_in_all_per_particle']:.0f} bytes a particle, of which {memory['bytes_per_particle']:.0f} its "
        f"own; {memory['bytes_per_listed_pair']:.0f} a listed pair, {memory['bytes_per_contact']:.0f} a contact; process at most "
        f"{1e-6 * memory['peak_process_bytes']:.0f} MB so far, compiler included",
        f"  first step after {figures['first_step_s']:.1f} s",
    ]
    return text
