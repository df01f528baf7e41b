"""How far a long run is, and how long it will still take."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn
from rich.progress import Progress as Display

LINE_INTERVAL = 5.0  # between two plain lines [s]


class Progress:
    """What a long run tells as it goes: `bar.update(done, "cycle 3")`."""

    def update(self, done: float, text: str = "") -> None:
        """Tell that `done` of the total is behind us; this one keeps it to itself."""


class Pace:
    """The time left at the pace since the first call: what came before it was getting ready, such as compiling."""

    def __init__(self, total: float) -> None:
        self.total = total
        self.first: tuple[float, float] | None = None  # moment [s], done

    def left(self, done: float) -> str:
        """`4 min 12 s left`; empty at the first call."""
        moment = time.monotonic()
        self.first = self.first or (moment, done)
        begun, already = self.first
        return (
            time_left(moment - begun, (done - already) / (self.total - already))
            if already < self.total
            else ""
        )


class PlainLines(Progress):
    """One line at a time, at most one every five seconds: for files and logs."""

    def __init__(self, total: float, label: str, stream: TextIO) -> None:
        self.total, self.label, self.stream = total, label, stream
        self.pace, self.last_line = Pace(total), time.monotonic()

    def update(self, done: float, text: str = "") -> None:
        """Print a line, if the last one is old enough."""
        moment, left = time.monotonic(), self.pace.left(done)
        if moment - self.last_line < LINE_INTERVAL:
            return
        self.last_line = moment
        parts = [f"{self.label}: {done / self.total:.0%}", left, text]
        print(", ".join(part for part in parts if part), file=self.stream, flush=True)


class Bar(Progress):
    """A bar that fills, on a terminal."""

    def __init__(self, total: float, label: str, display: Display) -> None:
        self.pace, self.display = Pace(total), display
        self.task = display.add_task(label, total=total, left="", text="")

    def update(self, done: float, text: str = "") -> None:
        """Move the bar."""
        self.display.update(self.task, completed=done, left=self.pace.left(done), text=text)


@contextmanager
def progress(total: float, label: str, quiet: bool = False) -> Iterator[Progress]:
    """Show progress on the error stream: a bar on a terminal, plain lines elsewhere, nothing when quiet.

    Parameters
    ----------
    total
        What `update` counts up to, usually simulated seconds; above zero.
    label
        What is going on, in a word or two.
    quiet
        Show nothing.
    """
    if quiet:
        yield Progress()
    elif sys.stderr.isatty():
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TextColumn("{task.fields[left]}"),
            TextColumn("{task.fields[text]}"),
        )
        with Display(*columns, console=Console(stderr=True)) as display:
            yield Bar(total, label, display)
    else:
        yield PlainLines(total, label, sys.stderr)


def time_left(elapsed: float, fraction: float) -> str:
    """`4 min 12 s left`, at the pace so far; empty at the start and at the end."""
    if not 0.0 < fraction < 1.0:
        return ""
    return f"{clock(elapsed * (1.0 - fraction) / fraction)} left"


def clock(seconds: float) -> str:
    """A duration [s] as people say it: `12 s`, `4 min 12 s`, `3 h 05 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
