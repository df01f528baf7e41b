"""gmsh, loaded only where a mesh is made: on a bare machine it misses a system library."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from wearfem.errors import UserError

PACKAGES = "libglu1-mesa libgl1 libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1"  # Debian's, of what gmsh opens


@contextmanager
def gmsh_model(name: str, options: Mapping[str, float]) -> Iterator[Any]:
    """gmsh with an empty model and these options; silent, and on one thread, so that meshes repeat. A session that is open is left open.

    Raises
    ------
    UserError
        where gmsh cannot be loaded; the sentence names what to install.
    """
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise UserError(
            f"gmsh cannot be loaded ({error}); pip install gmsh, and the system libraries that it opens (on Debian and Ubuntu: "
            f"sudo apt-get install {PACKAGES})"
        ) from error
    fresh = not gmsh.isInitialized()
    if fresh:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.model.add(name)
    for option, value in ({"General.Terminal": 0, "General.NumThreads": 1} | dict(options)).items():
        gmsh.option.setNumber(option, value)
    try:
        yield gmsh
    finally:
        gmsh.model.remove()
        if fresh:
            gmsh.finalize()
