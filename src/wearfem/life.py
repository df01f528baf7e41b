"""The life of a liner, cycle after cycle: each is written down when it is done, and told in one line."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType
from typing import Any

from wearfem.case import LifeCase, Window
from wearfem.cycle import CycleReport, Sampler, State, Tell, cycle, first_state
from wearfem.history import (
    History,
    computing_of,
    cycles_of,
    read_cycle,
    read_history,
    service_time_of,
    write_cycle,
    write_series,
)
from wearfem.loads import FacetLoads
from wearfem.progress import clock, progress
from wearfem.record import alone
from wearfem.sharpness import of_whole_face
from wearfem.surface import Surface
from wearfem.units import day, hour, minute, tonne


def live(case: LifeCase, run: Path, quiet: bool = False) -> History:
    """Follow the life of a case to its end, from the beginning or from the last cycle that the run folder holds.

    The first Ctrl-C lets the cycle end and be written; the second stops at once. Nothing that is written is lost by either. While it
    lives, no other process can go on with the same folder.
    """
    with alone(run):
        return _live(case, run, quiet)


def _live(case: LifeCase, run: Path, quiet: bool) -> History:
    done = cycles_of(run)
    state = read_cycle(run, done)[0] if done else first_state(case)
    times = [service_time_of(run, number) for number in range(1, done + 1)]
    if done:
        write_series(run, times)  # a kill may have come between the last cycle and its list
    started = None  # after the first cycle, which may have compiled
    with _interrupted() as stop:
        while not state.ended:
            state, report = _one(case, state, run, quiet, times)
            started = started or time.monotonic()
            print(line(report, case, time.monotonic() - started, state, done), flush=True)
            if stop.is_set() and not state.ended:
                print(f"stopped after cycle {state.cycle}; go on with: wearfem resume {run}", flush=True)
                raise KeyboardInterrupt
    print(f"ended: {state.ended}", flush=True)
    history = read_history(run)
    if sharp := of_whole_face(history, case):
        print(sharp.words(history.life[-1].time), flush=True)
    if spent := computing_of(run).words():
        print(spent, flush=True)
    return history


@dataclass
class Timed:
    """A sampler beside a clock."""

    sampler: Sampler
    seconds: float = 0.0  # that it has computed

    def sample(
        self, flow: Any, surface: Surface, window: Window, tell: Tell | None = None
    ) -> tuple[Any, FacetLoads]:
        """What the sampler says."""
        begun = time.monotonic()
        done = self.sampler.sample(flow, surface, window, tell)
        self.seconds += time.monotonic() - begun
        return done


def _one(
    case: LifeCase, state: State, run: Path, quiet: bool, times: list[float]
) -> tuple[State, CycleReport]:
    """One cycle, written down."""
    begun, sampler = time.monotonic(), Timed(case.sampler)
    number = state.cycle + 1
    planned = case.warm_up + (state.jump.window if state.jump else case.window.duration)
    with progress(planned, f"{case.name}: cycle {number}", quiet) as bar:
        new, report = cycle(
            replace(case, sampler=sampler),
            state,
            lambda seconds, word: bar.update(min(seconds, planned), word),
        )
    write_cycle(
        run, new, report, worn=state.now, run_time=time.monotonic() - begun, flow_time=sampler.seconds
    )
    times.append(report.service_time)
    write_series(run, times)
    return new, report


def line(report: CycleReport, case: LifeCase, elapsed: float, state: State, resumed: int = 0) -> str:
    """A cycle in one line: where the life stands, how far the jump went and why no further, what is left with its interval.

    Parameters
    ----------
    report, case, state
        Of the cycle, and after it.
    elapsed
        [s] that this process has run since its first cycle.
    resumed
        Cycles that were done before it began.
    """
    jump, life = report.jump, report.life
    left = min(life.time, case.stop.service_time) - report.service_time
    interval = report.end_error(case.goal.deviations)
    parts = [
        f"cycle {report.cycle:3d}",
        f"{words(report.service_time)} served",
        f"{report.throughput / tonne:,.0f} t",
        f"deepest {1e3 * report.depth.max():.4g} mm",
        f"{1e6 * report.worn_volume:.4g} cm3",
        f"jump {words(report.taken * jump.duration)} ({'end' if state.ended else jump.limited_by})",
        f"end of life at {words(life.time, interval)} ({case.goal.confidence:.0%}, at this rate)",
    ]
    if report.strain is not None:
        parts.append(f"von Mises {1e-6 * report.strain.largest_von_mises:.4g} MPa")
    if not report.kept:
        parts.insert(1, "sample rejected, jump taken back")
    if report.event:
        parts.append(report.event)
    passed = report.service_time - case.liner.service_time
    if not state.ended and passed > 0.0 and not resumed:
        parts.append(f"about {clock(elapsed * max(left, 0.0) / passed)} to run")
    return ", ".join(parts)


def words(seconds: float, interval: float | None = None) -> str:
    """A service time as people say it, with its interval in the same unit: `41.2 d`, `3.5 h`, `12 min`, `4 s`, `68.9 +- 1.5 d`."""
    unit, name = next(
        (
            (one, name)
            for one, name in ((day, "d"), (hour, "h"), (minute, "min"))
            if abs(seconds) >= 2.0 * one
        ),
        (1.0, "s"),
    )
    if interval is not None:
        return f"{seconds / unit:.4g} +- {interval / unit:.2g} {name}"
    return f"{seconds / unit:.{4 if name != 's' else 3}g} {name}"


@contextmanager
def _interrupted() -> Iterator[threading.Event]:
    """An event that the first Ctrl-C sets; the second raises KeyboardInterrupt as ever."""
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():  # signals are the main thread's
        yield asked
        return

    def handle(number: int, frame: FrameType | None) -> None:
        if asked.is_set():
            raise KeyboardInterrupt
        asked.set()
        print("stopping when this cycle is written; press Ctrl-C again to stop at once", flush=True)

    before = signal.signal(signal.SIGINT, handle)
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
