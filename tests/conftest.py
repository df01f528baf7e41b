"""What a machine lacks is told as a skipped test, not as a failed one."""

import pytest

from wearfem.errors import UserError
from wearfem.liner.mesher import gmsh_model


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    """Skip a test that makes a mesh where gmsh's system libraries are missing, as on a bare Debian."""
    try:
        return (yield)
    except (UserError, OSError) as error:  # by wearfem, or by a test's own `import gmsh`
        if "gmsh cannot be loaded" in str(error) or "cannot open shared object file" in str(error):
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
