"""All numba policy: options, the bridge that lets a law be a plain NamedTuple, and where compiled code is kept.

Every compiled function of wearfem is decorated here and nowhere else, so that one page answers "which flags?".

* ``error_model="numpy"``: division by zero gives inf instead of a Python error; the default's checks stop
  vectorisation (measured: 37.8 ns against 16.8 ns a contact).
* no ``fastmath``: it gave nothing and costs reproducibility.
* threading layer ``omp``: 1.7 us a parallel region (``workqueue`` 122 us, ``tbb`` 519 us).
* ``GOMP_SPINCOUNT=10000``: a thread that waits for the others sleeps after some microseconds. libgomp's own value lets it burn a core that
  another program has work for (5 000 particles on 2 cores at load 5, in turns: 1.4 million particle-steps/s with libgomp's value, 4.0
  with 20 000, 7.5 with 1000). On idle cores: 12.0-14.4 with libgomp's value, 13.2-13.8 with 1000, 14.2-15.7 with 10 000.
* ``cache=True`` does not notice an edited law in another file, so the cache directory carries a hash of the sources.
"""

import hashlib
import inspect
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


def _source_hash(package: Path) -> str:
    """Hash of every source that is compiled, with ``WEARFEM_CASE`` (laws written in a case) mixed in."""
    digest = hashlib.sha256(os.environ.get("WEARFEM_CASE", "").encode())
    for source in [package / "jit.py", package / "vector.py", *sorted((package / "dem").glob("*.py"))]:
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _cache_directory() -> str:
    root = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "wearfem"
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError:
        root = Path(tempfile.gettempdir()) / f"wearfem-{os.getuid()}"
    return str(root / _source_hash(Path(__file__).parent))


os.environ.setdefault("NUMBA_CACHE_DIR", _cache_directory())
os.environ.setdefault("GOMP_SPINCOUNT", "10000")  # read when libgomp is loaded
os.environ.setdefault("NUMBA_THREADING_LAYER_PRIORITY", "omp workqueue tbb")  # omp needs libgomp1

import numba  # noqa: E402  (the cache directory must be named before numba is imported)
from numba import prange as prange  # noqa: E402
from numba.extending import overload_method  # noqa: E402

OPTIONS = {"error_model": "numpy", "cache": True, "nogil": True}


def compiled(function: Function) -> Function:
    """Compile a serial function."""
    return numba.njit(**OPTIONS)(function)


def inlined(function: Function) -> Function:
    """Compile a small function that LLVM shall always inline, so that loops over it vectorise. It may not allocate."""
    return numba.njit(forceinline=True, _nrt=False, **OPTIONS)(function)


def kernel(function: Function) -> Function:
    """Compile a serial function that allocates nothing: without it every access to an array of a NamedTuple costs
    two atomic counts (measured: 460 ns a triangle against 20)."""
    return numba.njit(_nrt=False, **OPTIONS)(function)


def parallel(function: Function) -> Function:
    """Compile a driver; a ``prange`` body is one call to a serial function (numba drops tuple writes otherwise)."""
    return numba.njit(parallel=True, **OPTIONS)(function)


def law_method(declaration: Callable[..., Any]) -> None:
    """Let compiled code call the method of this name and signature on any law that is a NamedTuple.

    The method stays plain Python: it runs, and is tested, without the JIT too.
    """

    def resolve(self: Any, *arguments: Any) -> Callable[..., Any] | None:
        method = getattr(self.instance_class, declaration.__name__, None)
        if method is None:
            return None
        expected, given = inspect.signature(declaration), inspect.signature(method)
        if list(expected.parameters) != list(given.parameters):
            raise TypeError(
                f"{self.instance_class.__name__}.{declaration.__name__}{given} was given; "
                f"its arguments must be named {expected}."
            )
        return FunctionType(
            method.__code__, method.__globals__, method.__name__, method.__defaults__, method.__closure__
        )

    resolve.__signature__ = inspect.signature(declaration)  # type: ignore[attr-defined]
    options = {"error_model": "numpy", "forceinline": True, "_nrt": False}
    overload_method(numba.types.BaseNamedTuple, declaration.__name__, jit_options=options)(resolve)


def thread_count() -> int:
    """Threads that parallel drivers use now."""
    return int(numba.get_num_threads())


def set_thread_count(count: int) -> None:
    """Use `count` threads from now on, at most as many as the machine has cores. Results do not depend on it."""
    numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))


def most_threads() -> int:
    """As many threads as can be used at all."""
    return int(numba.config.NUMBA_NUM_THREADS)
