"""The run folder: what a run writes down.

Every file is written beside its place and renamed when it is complete, so that neither a kill nor a full disk
leaves half a file under a final name.
"""

import json
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass, fields, is_dataclass
from datetime import UTC, datetime
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from wearfem import __version__
from wearfem.case import Case, Figure, LifeCase
from wearfem.errors import UserError, in_words

RECORDED_PACKAGES = ("numpy", "numba", "llvmlite", "scipy", "scikit-fem", "meshio", "gmsh", "pyvista", "h5py")


@dataclass(frozen=True)
class RunFolder:
    """A folder that belongs to one run."""

    path: Path

    @classmethod
    def create(cls, path: Path) -> "RunFolder":
        """Make the folder; one that holds anything is refused, and left as it is."""
        try:
            if path.is_dir() and not any(path.iterdir()):
                if not os.access(path, os.W_OK | os.X_OK):
                    raise PermissionError(13, "Permission denied")
            else:
                path.mkdir(parents=True)
        except FileExistsError:
            kind = "is a folder with files in it" if path.is_dir() else "is in the way"
            raise UserError(
                f"the output folder {path} {kind}: give --out a new one, or remove it; nothing was changed"
            ) from None
        except OSError as error:
            raise UserError(
                f"cannot make the output folder {path} ({error.strerror}): give --out one that can be written"
            ) from error
        return cls(path)

    @classmethod
    def create_free(cls, case_name: str, parent: Path = Path("runs")) -> "RunFolder":
        """Make `runs/<case>`, or `runs/<case>-2` and so on where that exists."""
        number = 1
        while (path := parent / (case_name if number == 1 else f"{case_name}-{number}")).exists():
            number += 1
        return cls.create(path)

    def write_manifest(
        self, case: Case | LifeCase, started: datetime, finished: datetime | None = None
    ) -> None:
        """Write `manifest.json`, at the start and again at the end; `finished` stays null in a killed run."""
        write_json(self.path / "manifest.json", manifest(case, started, finished))

    def write_figures(self, figures: Sequence[Figure]) -> None:
        """Write `figures.json`."""
        write_json(self.path / "figures.json", figure_list(figures))


def now() -> datetime:
    """The time, in UTC."""
    return datetime.now(UTC)


def figure_list(figures: Sequence[Figure]) -> list[dict[str, Any]]:
    """The figures as plain values, each with its verdict."""
    return [asdict(figure) | {"verdict": figure.verdict} for figure in figures]


def manifest(case: Case | LifeCase, started: datetime, finished: datetime | None = None) -> dict[str, Any]:
    """Everything needed to run this again and get the same numbers."""
    files = ([case.folder / "case.py"] if case.folder else []) + list(case.files)
    return {
        "case": case.name,
        "folder": case.folder,
        "settings": case.settings,
        "seed": case.settings.get("seed"),
        "started": started.isoformat(timespec="seconds"),
        "finished": finished and finished.isoformat(timespec="seconds"),
        "sha256": {str(file): file_hash(file) for file in files},
    } | this_machine()


def read_manifest(run: Path) -> dict[str, Any]:
    """What a run folder says of itself."""
    try:
        content = json.loads((run / "manifest.json").read_text(encoding="utf-8"))
        if not isinstance(content["folder"], str) or not isinstance(content["settings"], dict):
            raise ValueError("it names no case")
        return content
    except (FileNotFoundError, NotADirectoryError):
        raise UserError(
            f"{run} is no run folder, it has no manifest.json: give the folder that wearfem run wrote to"
        ) from None
    except OSError as error:
        raise UserError(
            f"{run / 'manifest.json'} cannot be read ({error.strerror}): make it readable"
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(
            f"{run / 'manifest.json'} cannot be read ({error}): it was not written by wearfem run"
        ) from error


def check_same(run: Path, begun: Mapping[str, Any], here: Mapping[str, Any]) -> None:
    """Refuse to go on with a run by another case, other files or another version: the rest would not belong to its beginning."""
    if begun["versions"]["wearfem"] != here["versions"]["wearfem"]:
        raise UserError(
            f"{run} was begun by wearfem {begun['versions']['wearfem']}, and this is {here['versions']['wearfem']}: go on with that "
            "version, or run the case again"
        )
    for file, digest in begun["sha256"].items():
        if here["sha256"].get(file) != digest:
            raise UserError(
                f"{file} is not what it was when {run} was begun: put the old one back, or run the case again in a new folder"
            )
    changed = [name for name, value in here["versions"].items() if begun["versions"].get(name) != value]
    if changed or begun["git_commit"] != here["git_commit"]:
        what = in_words(changed) if changed else "the commit of wearfem"
        print(
            f"note: {what} is not what it was when {run} was begun; the last bits may differ from an unbroken run"
        )


def this_machine() -> dict[str, Any]:
    """What computes here: the command, versions of all that takes part, the platform."""
    return {
        "command": sys.argv,
        "versions": {"wearfem": __version__, "python": platform.python_version()} | _package_versions(),
        "git_commit": _git_commit(),
        "platform": platform.platform(),
        "cpu_count": os.cpu_count(),
    }


def file_hash(file: Path) -> str:
    """The SHA-256 of a file's content, in hexadecimal."""
    try:
        return sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise UserError(f"cannot read {file} ({error.strerror}): the case needs it") from error


def _package_versions() -> dict[str, str | None]:
    versions: dict[str, str | None] = {}
    for package in RECORDED_PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = None
    return versions


def _git_commit() -> str | None:
    """The commit of this wearfem, with `-changed` where files differ from it; None outside its repository."""
    package = Path(__file__).resolve().parent
    repository = package.parent.parent
    if not (repository / ".git").exists():
        return None
    command = [
        "git",
        "-C",
        str(repository),
        "describe",
        "--always",
        "--abbrev=40",
        "--exclude=*",
        "--dirty=-changed",
    ]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; what is written there is renamed when it is all on the disk."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        with open(temporary, "rb") as file:
            os.fsync(file.fileno())
        os.replace(temporary, path)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise UserError(f"cannot write {path} ({reason}): make room there or choose another place") from error
    finally:
        temporary.unlink(missing_ok=True)


def sweep(run: Path) -> None:
    """Take away what killed processes left half written in a run folder; their final names never saw it."""
    for part in run.rglob(".*.part"):
        try:
            os.kill(int(part.name.split(".")[-2]), 0)
        except ProcessLookupError:
            with suppress(OSError):  # it takes room and does no harm
                part.unlink()
        except (OSError, ValueError, OverflowError):
            continue  # of a process that lives, or none of ours


def require_writable(file: Path) -> None:
    """Refuse, before the work is done, a file that could not be written after it."""
    if file.is_dir():
        raise UserError(f"{file} is a folder: give the name of a file in it")
    if not file.parent.is_dir() or not os.access(file.parent, os.W_OK | os.X_OK):
        raise UserError(f"cannot write {file}: {file.parent} must be a folder that exists and can be written")


@contextmanager
def alone(run: Path) -> Iterator[None]:
    """Be the only process that goes on with a run; a file system that knows no locks lets all.

    Raises
    ------
    UserError
        where another process is at work on it.
    """
    with ExitStack() as held:
        with suppress(OSError, ImportError):
            import fcntl  # which Windows does not have

            folder = os.open(run, os.O_RDONLY)
            held.callback(os.close, folder)  # which ends the lock, as does a kill
            try:
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise UserError(
                    f"another process is at work on {run}: let it finish, or stop it first; nothing was changed"
                ) from None
        yield


def write_json(path: Path, content: Any) -> None:
    """Write plain values, dataclasses and arrays as JSON; numbers that are not finite become null."""
    text = json.dumps(_plain(content), indent=2, allow_nan=False) + "\n"
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _plain(content: Any) -> Any:
    """The same content in the types that JSON knows."""
    match content:
        case Mapping():
            return {str(key): _plain(value) for key, value in content.items()}
        case list() | tuple():
            return [_plain(value) for value in content]
        case np.ndarray() | np.generic():
            return _plain(content.tolist())
        case float():
            return content if np.isfinite(content) else None
        case None | bool() | int() | str():
            return content
        case _ if is_dataclass(content) and not isinstance(content, type):
            return _plain(asdict(content))
        case _:
            return str(content)


@contextmanager
def hdf5_file(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file to fill; it appears under its name when it is complete."""
    with whole_file(path) as temporary:
        try:
            with h5py.File(temporary, "w") as file:
                yield file
        except RuntimeError as error:  # what h5py raises when the last flush does not fit on the disk
            number = re.search(r"errno = (\d+)", str(error))
            if number is None:
                raise
            raise OSError(int(number[1]), "HDF5 could not write") from error


def write_loads(group: h5py.Group, loads: Any) -> None:
    """Write every field of a dataclass or NamedTuple into an HDF5 group.

    Arrays become datasets with the attributes `unit` and `shape` from the field's metadata, numbers and words
    become attributes of the group, dataclasses become groups, and None is left out.
    """
    for name, value, metadata in _fields_of(loads):
        if value is None:
            continue
        if is_dataclass(value) or hasattr(value, "_fields"):
            write_loads(group.create_group(name), value)
        elif isinstance(value, np.ndarray):
            squeeze = "gzip" if value.ndim else None  # most facets are never touched: zeros
            dataset = group.create_dataset(name, data=value, compression=squeeze)
            for label in ("unit", "shape"):
                if label in metadata:
                    dataset.attrs[label] = metadata[label]
        else:
            group.attrs[name] = value


def _fields_of(loads: Any) -> Iterable[tuple[str, Any, Mapping[str, Any]]]:
    if is_dataclass(loads):
        return [(field.name, getattr(loads, field.name), field.metadata) for field in fields(loads)]
    return [(name, getattr(loads, name), {}) for name in loads._fields]


def write_surface(
    path: Path, point: np.ndarray, triangle: np.ndarray, cell_data: Mapping[str, np.ndarray] | None = None
) -> None:
    """Write a triangulated surface as VTKHDF PolyData, which ParaView (from 5.12) and pyvista open as it is.

    Parameters
    ----------
    path
        The file, ending in `.vtkhdf`.
    point
        (p, 3) corners [m].
    triangle
        (t, 3) indices of the corners.
    cell_data
        (t,) or (t, k) arrays by name with unit, like `depth [m]`; HDF5 keeps `/` for itself, so `m/s` is
        written as `m per s`.
    """
    count = len(triangle)
    with hdf5_file(path) as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        root.attrs.create("Type", np.bytes_("PolyData"))
        root["NumberOfPoints"] = np.array([len(point)], dtype=np.int64)
        root["Points"] = np.asarray(point, dtype=np.float64)
        for kind in ("Vertices", "Lines", "Polygons", "Strips"):
            cells = count if kind == "Polygons" else 0
            group = root.create_group(kind)
            group["NumberOfCells"] = np.array([cells], dtype=np.int64)
            group["NumberOfConnectivityIds"] = np.array([3 * cells], dtype=np.int64)
            group["Offsets"] = 3 * np.arange(cells + 1, dtype=np.int64)
            group["Connectivity"] = np.asarray(triangle, dtype=np.int64).ravel()[: 3 * cells]
        data = root.create_group("CellData")
        for name, values in (cell_data or {}).items():
            if len(values) != count:
                raise ValueError(f"{name} has {len(values)} values for {count} triangles")
            data[name.replace("/", " per ")] = np.ascontiguousarray(values)
