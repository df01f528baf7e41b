"""Progress: few plain lines, and a time left that follows from the pace."""

import io

import pytest

from wearfem import progress as module
from wearfem.progress import PlainLines, clock, progress, time_left


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0 s"), (59.4, "59 s"), (59.6, "1 min 00 s"), (252.0, "4 min 12 s"), (11100.0, "3 h 05 min")],
)
def test_durations_read_as_people_say_them(seconds, text):
    assert clock(seconds) == text


@pytest.mark.parametrize(
    ("fraction", "text"), [(0.0, ""), (1.0, ""), (0.25, "30 s left"), (0.5, "10 s left"), (1.1, "")]
)
def test_time_left_follows_the_pace(fraction, text):
    assert time_left(10.0, fraction) == text


def test_plain_lines_are_at_least_five_seconds_apart(monkeypatch):
    moment = 0.0
    monkeypatch.setattr(module.time, "monotonic", lambda: moment)
    stream = io.StringIO()
    lines = PlainLines(20.0, "slide", stream)
    for second in range(1, 21):
        moment = float(second)
        lines.update(moment, f"step {second}")
    assert stream.getvalue().splitlines() == [
        "slide: 25%, 15 s left, step 5",
        "slide: 50%, 10 s left, step 10",
        "slide: 75%, 5 s left, step 15",
        "slide: 100%, step 20",
    ]


def test_what_came_before_the_first_step_is_no_pace(monkeypatch):
    """100 s of compiling, then a quarter of the work in 10 s: three quarters take 30 s more."""
    moment = 0.0
    monkeypatch.setattr(module.time, "monotonic", lambda: moment)
    stream = io.StringIO()
    lines = PlainLines(40.0, "slide", stream)
    for moment, done in ((100.0, 0.0), (110.0, 10.0)):  # noqa: B007 read by the clock above
        lines.update(done)
    assert stream.getvalue().splitlines() == ["slide: 0%", "slide: 25%, 30 s left"]


@pytest.mark.parametrize("terminal", [True, False])
def test_progress_works_on_a_terminal_and_off_it(monkeypatch, capsys, terminal):
    monkeypatch.setattr(module.sys.stderr, "isatty", lambda: terminal)
    with progress(2.0, "slide") as bar:
        bar.update(1.0, "half")
    assert ("slide" in capsys.readouterr().err) == terminal  # off a terminal the first line comes after 5 s


def test_quiet_says_nothing(capsys):
    with progress(2.0, "slide", quiet=True) as bar:
        bar.update(1.0)
    assert capsys.readouterr().err == ""
