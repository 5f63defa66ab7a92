"""The provenance of a run: versions, revision, platform, hashes."""

from __future__ import annotations

import hashlib
import json
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import jax

from physagent_jax import __version__
from physagent_jax.kernels import describe_kernels
from physagent_jax.run.manifest import Manifest

_PACKAGES = ("jax", "jaxlib", "numpy", "scipy", "numba", "opencv-python-headless", "pydantic")


def make_manifest(*, command: str, prompt: str, seed: int, inputs: dict[str, str]) -> Manifest:
    """The passport of a run that is about to begin."""
    return Manifest(
        command=command,
        prompt=prompt,
        versions=read_versions(),
        git_revision=read_git_revision(),
        platform=describe_platform(),
        kernels=describe_kernels("auto"),
        seed=seed,
        inputs=inputs,
    )


def hash_settings(settings: object) -> str:
    """sha256 of JSON-serialisable settings in canonical form."""
    text = json.dumps(settings, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def read_versions() -> dict[str, str]:
    """Of this package, of Python and of what it computes with."""
    found = {"physagent_jax": __version__, "python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def describe_platform() -> str:
    """System, architecture and device."""
    return f"{platform.system()} {platform.machine()}, {jax.devices()[0].device_kind}"


def read_git_revision() -> str | None:
    """Revision of the package's own checkout; None for an installed package."""
    try:
        done = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None
