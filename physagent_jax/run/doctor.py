"""The state of this installation: what a run needs, what there is of it, and the command that brings the rest.

Like `run.installation`, it imports late: a part that cannot be examined is a problem that is reported.
"""

from __future__ import annotations

import dataclasses
import os
import platform
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from physagent_jax import __version__
from physagent_jax.core.errors import UserError
from physagent_jax.run.installation import Extra, Package, check_extras, check_packages, make_command

VARIABLES = ("JAX_", "XLA_", "NUMBA_", "PHYSAGENT_", "OMP_", "MKL_", "OPENBLAS_", "CUDA_", "TF_CPP_")
"""Beginnings of the names of environment variables that change what is computed, where, or how fast."""
LEAST_MEMORY, LEAST_DISK = 2e9, 1e9  # free [bytes] below which a run of the fast preset is at risk
_QUOTA, _MEMORY = Path("/sys/fs/cgroup/cpu.max"), Path("/proc/meminfo")


@dataclasses.dataclass(frozen=True)
class Problem:
    """A reason why runs fail here.

    Attributes:
        what: The problem.
        do: The remedy; "" = it is part of `what`.
    """

    what: str
    do: str = ""


@dataclasses.dataclass(frozen=True)
class Threads:
    """The cores of this machine and the threads that compute.

    Attributes:
        cores: Cores of the machine.
        usable: Cores that this process may use.
        quota: Cores that a container's limit on processor time amounts to; None = no limit.
        kernels: Threads of a CPU kernel; None = unknown.
    """

    cores: int
    usable: int
    quota: float | None
    kernels: int | None


@dataclasses.dataclass(frozen=True)
class Cache:
    """A folder of compiled code.

    Attributes:
        name: The kind of code that is kept there.
        folder: The folder; None = nothing is kept.
        count: Kernels or programs that are kept.
        total: Kernels that there are; None = any number.
        size: Size of the files [bytes].
        writable: True = this process may write there.
    """

    name: str
    folder: str | None
    count: int = 0
    total: int | None = None
    size: int = 0
    writable: bool = False


@dataclasses.dataclass(frozen=True)
class Compute:
    """The devices and kernels that compute.

    Attributes:
        platform: JAX's default platform ("cpu", "gpu").
        devices: All devices of JAX.
        kernels: "cpu (n threads)", "cuda", or "reference" for pure JAX.
        reason: The reason for the reference; None = the kernels are used.
    """

    platform: str
    devices: tuple[str, ...]
    kernels: str
    reason: str | None


@dataclasses.dataclass(frozen=True)
class Examination:
    """Everything that `physagent doctor` finds.

    Attributes:
        version: This package's version.
        python: Python's version.
        interpreter: Python's program.
        system: System and architecture.
        packages: Packages that are required.
        extras: Optional parts.
        compute: Devices and kernels; None = they cannot be examined.
        threads: Cores and threads.
        variables: Environment variables that matter and are set.
        caches: Folders of compiled code.
        video: The video encoder; None = there is none.
        free_memory: [bytes]; None = unknown.
        free_disk: In the current folder [bytes].
        problems: Reasons why runs fail here; none = all that a run needs is there.
    """

    version: str
    python: str
    interpreter: str
    system: str
    packages: tuple[Package, ...]
    extras: tuple[Extra, ...]
    compute: Compute | None
    threads: Threads
    variables: dict[str, str]
    caches: tuple[Cache, ...]
    video: str | None
    free_memory: int | None
    free_disk: int
    problems: tuple[Problem, ...]


def examine(prepare: Callable[[], object]) -> Examination:
    """Examines this installation.

    Args:
        prepare: Checks the environment as commands that compute do, with a `UserError` for what is wrong with it.
    """
    problems: list[Problem] = []
    packages: tuple[Package, ...] = ()
    try:
        packages = check_packages()
    except UserError as error:
        problems.append(Problem(error.what, error.do))
    problems += _judge_packages(packages)
    usable = _attempt(prepare, problems) if not problems else False
    compute = _attempt(_examine_compute, problems) if usable else None
    caches = _attempt(_examine_caches, problems) if usable else None
    free_memory, free_disk = _read_free_memory(), shutil.disk_usage(".").free
    if free_memory is not None and free_memory < LEAST_MEMORY:
        problems.append(Problem("less than 2 GB of memory are free", "End other programs"))
    if free_disk < LEAST_DISK:
        problems.append(Problem("less than 1 GB of disk is free here", "Make room, or use another folder"))
    return Examination(
        version=__version__,
        python=platform.python_version(),
        interpreter=sys.executable,
        system=f"{platform.system()} {platform.machine()}",
        packages=packages,
        extras=check_extras(),
        compute=compute or None,
        threads=_examine_threads(bool(usable)),
        variables={name: os.environ[name] for name in sorted(os.environ) if name.startswith(VARIABLES)},
        caches=caches or (),
        video=_examine_video(problems),
        free_memory=free_memory,
        free_disk=free_disk,
        problems=tuple(problems),
    )


def _judge_packages(packages: tuple[Package, ...]) -> list[Problem]:
    broken = [each for each in packages if each.problem]
    if not broken:
        return []
    return [Problem(", ".join(f"{each.name} {each.problem}" for each in broken), make_command(broken))]


def _attempt(part: Callable[[], Any], problems: list[Problem]) -> Any:
    """The result of a part of the examination; False, and a problem more, if it fails."""
    try:
        result = part()
    except UserError as error:
        got = "" if error.got is None else f" (got {error.got})"
        problems.append(Problem(error.what + got, error.do))
    except Exception as error:  # a broken installation raises anything; it is what is asked for
        problems.append(Problem(f"{part.__name__.strip('_')}: {type(error).__name__}: {error}"))
    else:
        return True if result is None else result
    return False


def _examine_compute() -> Compute:
    import jax

    from physagent_jax.kernels import describe_kernels, explain_reference

    reason = explain_reference() or None
    names = tuple(f"{each.platform}:{each.id} {each.device_kind}" for each in jax.devices())
    return Compute(jax.default_backend(), names, describe_kernels("auto"), reason)


def _examine_threads(importable: bool) -> Threads:
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    kernels = None
    if importable:
        from physagent_jax.kernels.threads import thread_count

        kernels = thread_count()
    return Threads(os.cpu_count() or 1, usable, _read_quota(), kernels)


def _read_quota() -> float | None:
    """Cores that the control group's limit on processor time amounts to; None = no limit, or none that is known."""
    try:
        most, period = _QUOTA.read_text().split()
        return int(most) / int(period) if most != "max" else None
    except (OSError, ValueError):
        return None


def _examine_caches() -> tuple[Cache, ...]:
    import jax

    from physagent_jax.kernels import use_cpu

    config: Any = jax.config  # its flags are not typed
    programs = config.jax_compilation_cache_dir
    caches = [Cache("programs", None)]
    if programs is not None:
        count, size = _measure(Path(programs), "*-cache")
        caches = [Cache("programs", str(programs), count, None, size, os.access(programs, os.W_OK))]
    if use_cpu():
        from physagent_jax.kernels import store
        from physagent_jax.simulation.ahead import list_targets

        folder, targets = store.find_folder(), list_targets()
        done = sum(store.is_stored(target) for target in targets)
        size = _measure(folder, "*")[1]
        caches.append(Cache("kernels", str(folder), done, len(targets), size, os.access(folder, os.W_OK)))
    return tuple(caches)


def _measure(folder: Path, pattern: str) -> tuple[int, int]:
    """Number and size [bytes] of the files below a folder whose names match."""
    sizes = [path.stat().st_size for path in folder.rglob(pattern) if path.is_file()]
    return len(sizes), sum(sizes)


def _examine_video(problems: list[Problem]) -> str | None:
    try:
        from physagent_jax.output.video import ENCODER, find_encoder

        name = find_encoder()
    except ImportError:
        return None  # the packages say so
    if name is None:
        problems.append(
            Problem(f"PyAV has no encoder {ENCODER}", "pip install --force-reinstall --only-binary av av")
        )
    return name


def _read_free_memory() -> int | None:
    """Memory that is free on this machine [bytes]; None if the system does not tell."""
    try:
        line = next(each for each in _MEMORY.read_text().splitlines() if each.startswith("MemAvailable:"))
        return 1024 * int(line.split()[1])
    except (OSError, StopIteration, ValueError):
        return None
