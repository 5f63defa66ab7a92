"""Shared fixtures, and compiled programs that the processes of one test run share."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

import jax
import pytest

from physagent_jax.kernels import programs

REPOSITORY = Path(__file__).resolve().parents[1]
ROBOT = REPOSITORY / "examples" / "assets" / "robot.ply"
_SHARED = "PHYSAGENT_TEST_PROGRAMS"  # the folder, for the workers and for what they start


def pytest_configure(config):
    """What one process of this run compiles, the others read: most of the suite's time goes into compiling."""
    programs.start_quick_to_compile()
    if _SHARED not in os.environ:
        os.environ[_SHARED] = folder = tempfile.mkdtemp(prefix="physagent-tests-")
        config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
    programs.keep_on_disk(Path(os.environ[_SHARED]))


@pytest.fixture(autouse=True, scope="module")
def programs_let_go():
    """What earlier modules have compiled is let go before one process runs out of memory mappings."""
    yield
    programs.release_programs()


@pytest.fixture
def x64():
    """Double precision for one test: exact answers deserve exact arithmetic."""
    with jax.enable_x64(True):
        yield


@pytest.fixture(scope="session")
def robot_path() -> Path:
    """The bundled 3D Gaussian object."""
    return ROBOT


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Real captures that are not part of the package."""
    path = REPOSITORY.parent / "shared" / "data"
    if not path.is_dir():
        pytest.skip("the folder of real captures is not present")
    return path
