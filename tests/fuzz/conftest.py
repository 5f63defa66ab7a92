"""Processes that cases may end, and a folder with warm caches and a run that nothing happened to."""

from __future__ import annotations

import fcntl
import os
import shutil
from pathlib import Path

import pytest

from physagent_jax.kernels import use_cpu
from tests.fuzz import seeds
from tests.fuzz.campaign import Examiner
from tests.fuzz.contract import BYSTANDER
from tests.fuzz.processes import run


@pytest.fixture(scope="session")
def examiner():
    """One process for all cases, until one of them is its end."""
    with Examiner() as examiner:
        yield examiner


@pytest.fixture(scope="session")
def base(tmp_path_factory) -> Path:
    """The folder; made once for all processes of pytest."""
    root = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        root = root.parent
    root = root / "interruption"
    root.mkdir(exist_ok=True)
    with open(root.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (root / "ready").is_file():
            (root / seeds.OBJECT).write_bytes(seeds.gaussians())
            (root / BYSTANDER).write_bytes(b"not yours\n")
            _take_kernels_along(root / "caches" / "physagent_jax" / "kernels")
            code, errors = run(root, root / "undisturbed")
            assert code == 0, errors
            (root / "ready").touch()
    return root


def _take_kernels_along(folder: Path) -> None:
    """Copy the kernels that this machine has compiled into a cache: compiling them is not what is tested."""
    if use_cpu():
        from physagent_jax.kernels import store  # needs Numba

        kernels = store.find_folder()
        folder.mkdir(parents=True, mode=0o700)
        shutil.copytree(kernels, folder / kernels.name, ignore=shutil.ignore_patterns(".*"))
