"""Studies: a case run over and over with other keywords, in parallel, each run in a process and a run folder of its own.

A run is known by the case and its keywords, so a study that was stopped goes on where it stood, and one that is given more values runs
those alone. A run that fails is a row like the others, with the reason.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

import wearfem
from wearfem.case import Case, LifeCase, load_any_case
from wearfem.errors import UserError, in_words
from wearfem.plan import Rows, grid, latin, listed, parse_ranges, parse_values, sobol
from wearfem.progress import clock, progress
from wearfem.record import (
    RunFolder,
    check_same,
    file_hash,
    manifest,
    now,
    read_manifest,
    require_writable,
    write_json,
)
from wearfem.settings import Value, did_you_mean
from wearfem.study_results import (
    Row,
    answer_lines,
    read_figures,
    read_rows,
    settings_words,
    size_of,
    varied,
    write_results,
    write_row,
)

RUNS = "runs"
THREADS = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
INTERRUPTED = 130  # exit code of a run that was asked to stop
SHOWN = 2  # figures told of each run


@dataclass(frozen=True)
class Job:
    """One run to make."""

    name: str  # of its folder: a hash of case and keywords
    given: Mapping[str, Value]  # keywords that the plan sets [SI]
    settings: Mapping[str, Any]  # all keywords [SI]
    in_cycles: bool  # a life can be resumed


def study(
    case_folder: Path,
    plan: Rows,
    out: Path | None = None,
    *,
    executor: Executor | None = None,
    workers: int | None = None,
    sizes: Sequence[str] = (),
    retry: bool = False,
    json_file: Path | None = None,
    quiet: bool = False,
) -> tuple[Row, ...]:
    """Run a case with every row of keywords of a plan and write down what came of it.

    Parameters
    ----------
    case_folder
        The folder with the `case.py`.
    plan
        Keywords [SI] of each run, from `wearfem.plan`: `grid`, `listed`, `sobol`, `latin`.
    out
        The study folder: a new one, or one of the same case to go on with. Without it `runs/<case>-study`, which is gone on with too.
    executor
        Anything like a `concurrent.futures.Executor`, as `dask_executor` gives it. Each of its workers starts a process of one thread for a
        run, which needs this version of wearfem and the case and study folders at the same paths.
    workers
        Runs at a time on this machine, where no executor is given; as many as it has cores without it.
    sizes
        Keywords that are sizes (of a mesh, a time step): observed order and converged answer are told for them, see
        `wearfem.convergence.converged`. Whole numbers count parts: their size is 1/number.
    retry
        Run again what has failed.
    json_file
        Where else to write the rows.
    quiet
        Show no progress.

    Returns
    -------
    tuple[Row, ...]
        All rows of the study folder, sorted by the keywords that vary, those of earlier plans too.

    Raises
    ------
    UserError
        before anything is run, for an unknown keyword or a value that the case refuses, whichever row it is in; for a folder that is not a
        study of this case as it is now.
    """
    if json_file:
        require_writable(json_file)
    jobs, written = prepare(case_folder, plan)
    for size in sizes:
        _check_size(size, jobs)
    folder = _open(out or Path("runs") / f"{written['case']}-study", written)
    done = {row.run for row in read_rows(folder) if row.status == "done" or not retry}
    waiting = [job for job in jobs if job.name not in done]
    print(
        f"{written['case']}: {len(waiting)} runs to make, {len(jobs) - len(waiting)} done before; writing to {folder}",
        flush=True,
    )
    started = time.monotonic()
    try:
        with _workers(executor, workers, len(waiting)) as pool:
            _run_all(pool, Path(written["folder"]), folder, waiting, quiet)
    finally:
        rows = read_rows(folder)
        found = write_results(folder, rows, sizes)
    for line in answer_lines(found):
        print(line)
    failed = [row for row in rows if row.status == "failed"]
    if json_file:
        write_json(json_file, rows)
    for row in failed:
        print(f"failed: {_words(row, varied(rows))}: {row.problem}")
    print(f"{len(rows)} rows, {len(failed)} failed; wrote {folder} in {clock(time.monotonic() - started)}")
    return rows


def planned(
    case_folder: Path,
    texts: Sequence[str],
    fixed: Mapping[str, Value],
    side_by_side: bool = False,
    sobol_count: int | None = None,
    latin_count: int | None = None,
    seed: int = 0,
) -> Rows:
    """The plan that the words of a command ask for: a grid, unless told to take values side by side or points in ranges."""
    if side_by_side + (sobol_count is not None) + (latin_count is not None) > 1:
        raise UserError("a study was asked for two plans at once: give one of --list, --sobol and --latin")
    defaults = load_any_case(case_folder, fixed).settings
    if sobol_count is None and latin_count is None:
        if any(".." in text for text in texts):
            raise UserError(
                "a range like 4..8*mm needs --sobol N or --latin N: give values like 8,6,4*mm, or one of these"
            )
        values = parse_values(texts)
        plan = listed(values) if side_by_side else grid(values)
    else:
        ranges = parse_ranges(texts)
        whole = [name for name in ranges if isinstance(defaults.get(name), int)]
        spread, count = (latin, latin_count) if sobol_count is None else (sobol, sobol_count)
        plan = spread(ranges, count or 0, seed, whole)
    twice = [name for name in plan[0] if name in fixed]
    if twice:
        raise UserError(f"{in_words(twice)} was given to --set and to the study: keep one of them")
    return tuple({**fixed, **row} for row in plan)


def prepare(case_folder: Path, plan: Rows) -> tuple[list[Job], dict[str, Any]]:
    """The jobs of a plan, each different, and what the study folder says of itself. Every case is built, so that mistakes are told now."""
    if not plan:
        raise UserError("a study was given no rows: it needs at least one")
    jobs: dict[str, Job] = {}
    written: dict[str, Any] = {}
    hashes: dict[str, str] = {}
    for given in plan:
        case = _built(case_folder, given, alone=len(plan) == 1)
        name = _name(case)
        jobs[name] = Job(name, given, case.settings, isinstance(case, LifeCase))
        written = written or manifest(case, now())
        hashes |= {str(file): file_hash(file) for file in case.files if str(file) not in hashes}
    return list(jobs.values()), json.loads(
        json.dumps(written | {"sha256": written["sha256"] | hashes}, default=str)
    )


def _built(case_folder: Path, given: Mapping[str, Value], alone: bool) -> Case | LifeCase:
    """The case of one row."""
    try:
        return load_any_case(case_folder, given)
    except UserError as error:
        if alone:
            raise
        raise UserError(f"nothing was run, because of the row {settings_words(given)}: {error}") from error


def _name(case: Case | LifeCase) -> str:
    """A run is known by what it was asked."""
    return sha256(repr((case.name, sorted(case.settings.items()))).encode()).hexdigest()[:12]


def _check_size(size: str, jobs: Sequence[Job]) -> None:
    keywords = jobs[0].settings
    if size not in keywords:
        raise UserError(
            f"{size} was to be taken as a size, but the case has no such keyword{did_you_mean(size, keywords)}; "
            f"its keywords are {in_words(list(keywords))}"
        )
    for job in jobs:
        size_of(size, job.settings[size])


def _open(folder: Path, written: Mapping[str, Any]) -> Path:
    """The study folder, new or gone on with."""
    if not (folder / "study.json").exists():
        RunFolder.create(folder)
        write_json(folder / "study.json", written)
        return folder.resolve()
    begun = _read_study(folder)
    if (begun["case"], begun["folder"]) != (written["case"], written["folder"]):
        raise UserError(
            f"{folder} is a study of {begun['case']} in {begun['folder']}, and this is {written['case']} in {written['folder']}: "
            "give --out another folder"
        )
    known = {file: file_hash(Path(file)) for file in begun["sha256"]}
    check_same(folder, begun, {**written, "sha256": known})
    new = {file: digest for file, digest in written["sha256"].items() if file not in begun["sha256"]}
    if new:
        write_json(folder / "study.json", begun | {"sha256": begun["sha256"] | new})
    return folder.resolve()


def _read_study(folder: Path) -> dict[str, Any]:
    try:
        begun = json.loads((folder / "study.json").read_text(encoding="utf-8"))
        for name in ("case", "folder", "sha256", "versions", "git_commit"):
            begun[name]
        return begun
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(
            f"{folder / 'study.json'} cannot be read ({error}): give --out another folder, or put the file back"
        ) from error


@contextmanager
def _workers(executor: Executor | None, workers: int | None, most: int) -> Iterator[Executor]:
    """The executor given, or threads that each wait for the process of one run."""
    if executor is not None:
        yield executor
        return
    if workers is not None and workers < 1:
        raise UserError(f"a study was given {workers} workers: it needs at least 1")
    count = workers or len(os.sched_getaffinity(0))
    pool = ThreadPoolExecutor(max(1, min(count, most)))
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The workers of a Dask scheduler, like `tcp://10.0.0.1:8786`, as an executor. Start them with one thread each.

    Raises
    ------
    UserError
        where dask.distributed is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise UserError(
            "a scheduler was given, but dask.distributed is not installed: install it with `pip install 'wearfem[study]'`"
        ) from error
    try:
        client = Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise UserError(
            f"no Dask scheduler answers at {address} ({error}): start one with `dask scheduler` and give the address that it prints"
        ) from error
    with client:
        yield client.get_executor(pure=False)


def _run_all(pool: Executor, case_folder: Path, folder: Path, jobs: Sequence[Job], quiet: bool) -> None:
    """Run the jobs; each is written down and told when it ends."""
    if not jobs:
        return
    running: dict[Future[Any], Job] = {
        pool.submit(
            run_one, str(case_folder), dict(job.given), str(folder / RUNS / job.name), job.in_cycles
        ): job
        for job in jobs
    }
    stopped, names = 0, _varied(jobs)
    try:
        with progress(len(jobs), "study", quiet) as bar:
            for number, future in enumerate(as_completed(running), 1):
                job = running[future]
                row = _row(job, future)
                if row is None:
                    stopped += 1
                else:
                    write_row(folder, row)
                    print(
                        f"{number} of {len(jobs)}  {row.status}  {_words(row, names)}: {_told(row)} ({clock(row.seconds)})",
                        flush=True,
                    )
                bar.update(number)
    except KeyboardInterrupt:
        for future in running:
            future.cancel()
        print(
            "stopping: runs in cycles end with the cycle that they are in; the same command goes on from there",
            flush=True,
        )
        raise
    if stopped:
        raise KeyboardInterrupt  # which the runs have heard first


def _row(job: Job, future: "Future[Any]") -> Row | None:
    """What a job has left; None where it was asked to stop, and is to go on another time."""
    try:
        told = future.result()
    except CancelledError as error:
        raise UserError(
            "the executor gave runs up, its scheduler or its workers are gone: start them again, the same command goes on"
        ) from error
    except Exception as error:  # the worker is lost, or could not even begin
        return Row(
            job.name, job.settings, "failed", 0.0, (), f"its worker failed ({type(error).__name__}: {error})"
        )
    if told is None:
        return None
    return Row(
        job.name,
        job.settings,
        told["status"],
        told["seconds"],
        read_figures(told["figures"]),
        told["problem"],
    )


def _words(row: Row, names: Sequence[str]) -> str:
    """What makes a run differ from the others, and where it is."""
    return settings_words({name: row.settings[name] for name in names}) or row.run


def _varied(jobs: Sequence[Job]) -> list[str]:
    """The keywords that are not the same in all jobs."""
    return [name for name in jobs[0].settings if len({repr(job.settings[name]) for job in jobs}) > 1]


def _told(row: Row) -> str:
    if row.status == "failed":
        return row.problem
    return (
        ", ".join(f"{figure.name} {figure.value:.6g} {figure.unit}" for figure in row.figures[:SHOWN])
        or "no figures"
    )


def run_one(case_folder: str, given: dict[str, Value], place: str, in_cycles: bool) -> dict[str, Any] | None:
    """Make one run in a process of its own, of one thread: an executor calls this on whatever machine it likes.

    A crash, or a kill for want of memory, is that run's alone. A life that was stopped is resumed; a run in stages is made anew, in
    a folder beside the old one.

    Returns
    -------
    dict or None
        `status`, `seconds`, `figures` and `problem` in plain values; None where it was asked to stop.
    """
    folder, resume = Path(place), False
    number = 1
    while folder.exists():
        state = _finished(folder)
        if state:
            return _result(folder)
        if state is False and in_cycles:
            resume = True
            break
        number += 1
        folder = Path(f"{place}-{number}")
    folder.parent.mkdir(parents=True, exist_ok=True)
    settings = [part for name, value in given.items() for part in ("--set", f"{name}={value!r}")]
    words = ["resume", str(folder)] if resume else ["run", case_folder, *settings, "--out", str(folder)]
    started = time.monotonic()
    log = Path(f"{place}.log")
    with open(log, "a", encoding="utf-8") as lines:
        ended = subprocess.run(
            [sys.executable, "-m", "wearfem.cli", *words, "--quiet"],
            stdin=subprocess.DEVNULL,
            stdout=lines,
            stderr=subprocess.PIPE,
            text=True,
            env=_environment(),
        )
        lines.write(ended.stderr)
    seconds = time.monotonic() - started
    if ended.returncode == 0:
        return _result(folder, seconds)
    if ended.returncode == INTERRUPTED:
        return None
    if ended.returncode < 0:
        why = f"its process was ended by signal {-ended.returncode}, as happens when memory runs out"
    else:
        why = (ended.stderr.strip().splitlines() or [f"it ended with code {ended.returncode}"])[-1]
    return {"status": "failed", "seconds": seconds, "figures": [], "problem": why.removeprefix("wearfem: ")}


def _environment() -> dict[str, str]:
    """The variables of this process, with one thread and the same wearfem."""
    source = str(Path(wearfem.__file__).resolve().parents[1])
    paths = [source, *filter(None, [os.environ.get("PYTHONPATH")])]
    return os.environ | dict.fromkeys(THREADS, "1") | {"PYTHONPATH": os.pathsep.join(paths)}


def _finished(folder: Path) -> bool | None:
    """Whether the run in a folder is finished; None for a folder that does not say."""
    try:
        return read_manifest(folder)["finished"] is not None and (folder / "figures.json").is_file()
    except UserError:
        return None


def _result(folder: Path, seconds: float | None = None) -> dict[str, Any]:
    """What a finished run has written; `seconds` as its manifest has them where it was not timed here."""
    figures = json.loads((folder / "figures.json").read_text(encoding="utf-8"))
    if seconds is None:
        told = read_manifest(folder)
        begun, ended = (datetime.fromisoformat(told[name]) for name in ("started", "finished"))
        seconds = (ended - begun).total_seconds()
    return {"status": "done", "seconds": seconds, "figures": figures, "problem": ""}
