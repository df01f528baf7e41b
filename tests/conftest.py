"""What a machine lacks is told as a skipped test, not as a failed one."""

import re

import pytest

from wearfem.errors import UserError
from wearfem.liner.mesher import gmsh_model

LIBRARIES = (  # of the system, that gmsh opens (readelf -d); the packages that hold them: wearfem.liner.mesher.PACKAGES
    "libGL", "libGLU", "libX11", "libXcursor", "libXext", "libXfixes", "libXft", "libXinerama", "libXrender", "libfontconfig", "libgomp",
)  # fmt: skip
MISSING = re.compile(rf"\b({'|'.join(LIBRARIES)})\.so[.0-9]*: cannot open shared object file")


def lacks_what_gmsh_opens(error: Exception) -> bool:
    """Whether it is about a system library of gmsh, and no other file that cannot be opened"""
    return MISSING.search(str(error)) is not None


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    """Skip a test that makes a mesh where gmsh's system libraries are missing, as on a bare Debian."""
    try:
        return (yield)
    except (UserError, OSError) as error:  # by wearfem, or by a test's own `import gmsh`
        if lacks_what_gmsh_opens(error):
            pytest.skip(str(error))
        raise


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    """The same for its fixtures."""
    return (yield from pytest_runtest_call(item))


@pytest.fixture
def meshing():
    """For tests whose other processes make meshes: skipped where gmsh cannot be loaded."""
    with gmsh_model("probe", {}):
        pass
