"""What the tests skip for: system libraries of gmsh, and nothing else that cannot be opened."""

import conftest
import pytest


@pytest.mark.parametrize(
    ("said", "skipped"),
    [
        ("libGLU.so.1: cannot open shared object file: No such file or directory", True),
        ("gmsh cannot be loaded (libXft.so.2: cannot open shared object file: No such file or directory); ...", True),
        ("libopenblas.so.0: cannot open shared object file: No such file or directory", False),
        ("libmyXft.so.2: cannot open shared object file: No such file or directory", False),
        ("gmsh cannot be loaded (No module named 'gmsh'); pip install gmsh", False),
        ("libGL.so.1: wrong ELF class", False),
    ],
)  # fmt: skip
def test_only_what_gmsh_opens_is_skipped(said, skipped):
    assert conftest.lacks_what_gmsh_opens(OSError(said)) is skipped
