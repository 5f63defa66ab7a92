"""Shared fixtures, and compiled programs that the processes of one test run share."""

from __future__ import annotations

import contextlib
import ctypes
import dataclasses
import functools
import gc
import hashlib
import os
import sys
import threading
import warnings
from collections import OrderedDict
from pathlib import Path
from typing import Any

import jax
import pytest
from jax._src import compiler
from jax._src.interpreters import mlir
from jax._src.lib.mlir import ir

from physagent_jax.kernels import programs
from physagent_jax.kernels.folders import describe_processor, make_private_folder
from physagent_jax.scene import body, burden
from physagent_jax.scene.presets import PRESETS, PresetName

REPOSITORY = Path(__file__).resolve().parents[1]
ROBOT = REPOSITORY / "examples" / "assets" / "robot.ply"


_SHARED = "PHYSAGENT_TEST_PROGRAMS"  # the folder, for the workers and for what they start
QUICK_TO_COMPILE = "--xla_backend_optimization_level=1" + (
    " --xla_cpu_use_fusion_emitters=false --xla_cpu_parallel_codegen_split_count=1"
    " --xla_backend_extra_options=-fast-isel=true,-force-vector-width=1"
    if jax.__version_info__ < (0, 11)
    else ""
)


RARELY = (100_000, 20, 50)
"""Thresholds of the garbage collector: with Python's own, a seventh of the suite's time went into collecting.

A process that does little but trace and compile spends a third of its time so.
"""


def compile_quickly() -> None:
    """Has LLVM spend less on optimising, and not in parts, and XLA make its loops in the older of its two ways.

    LLVM chooses instructions as for code that is not optimised, and leaves loops as they are in place of making them
    of vectors, which are several times as much code: a fifth less to compile, for loops that run as quickly.

    For this process only: what tests start is compiled as users have it, unless its variables say otherwise.
    XLA reads its flags once, and ends the program at one that it does not know.
    """
    given = os.environ.get("XLA_FLAGS")
    os.environ["XLA_FLAGS"] = f"{given or ''} {QUICK_TO_COMPILE}".strip()
    jax.jit(lambda: 0)()
    if given is None:
        del os.environ["XLA_FLAGS"]
    else:
        os.environ["XLA_FLAGS"] = given


def repeats(program: Any) -> bool:
    """Return whether a program has a loop, or calls what may have one."""
    found = []

    def look(operation):
        if operation.name in ("stablehlo.while", "stablehlo.custom_call"):
            found.append(operation)
            return ir.WalkResult.INTERRUPT
        return ir.WalkResult.ADVANCE

    program.operation.walk(look)
    return bool(found)


def compile_what_runs_once_least() -> None:
    """Has programs without a loop compiled with the fewest optimisations: nine of ten, such as single operations.

    Compiling one takes half as long then, which is longer than it runs. This process only, as `compile_quickly`.
    """
    compiled = compiler.compile_or_get_cached

    def compile_or_get_cached(backend, computation, devices, compile_options, *more, **named):
        if not repeats(computation):
            chosen = compile_options.executable_build_options.debug_options
            chosen.xla_backend_optimization_level = 0
            chosen.xla_llvm_disable_expensive_passes = True
        return compiled(backend, computation, devices, compile_options, *more, **named)

    compiler.compile_or_get_cached = compile_or_get_cached


def lower_in_few_contexts(programs_each: int = 32) -> None:
    """Has JAX lower some programs after each other in one MLIR context, where it makes one for each.

    To make one takes a quarter of the time in which a single operation is compiled. Each stays, with 1 MB, as long as
    its program does: a process of the suite grew to 6 GB.
    """
    make, local = mlir.make_ir_context, threading.local()

    def make_ir_context():
        if not getattr(local, "left", 0):
            local.context, local.left = make(), programs_each
        local.left -= 1
        return local.context

    mlir.make_ir_context = make_ir_context


def keep_freed_memory() -> None:
    """Has the C library keep memory that is freed: XLA asks for much, briefly and often, to compile a program."""
    keep, most = getattr(ctypes.CDLL(None), "mallopt", None), 1 << 28
    if keep is not None:  # glibc
        for option in (-1, -3):  # M_TRIM_THRESHOLD, M_MMAP_THRESHOLD
            keep(option, most)
        keep(-2, 1 << 24)  # M_TOP_PAD


def share_programs() -> None:
    """Read and keep the programs of a test run in a process that it has started; do nothing in others."""
    if _SHARED in os.environ:
        programs.keep_on_disk(Path(os.environ[_SHARED]))


def compile_as_tests_do() -> None:
    """Compile quickly, and nothing twice, in a process that a test run has started; do nothing in others."""
    if _SHARED in os.environ:
        gc.set_threshold(*RARELY)
        compile_quickly()
        compile_what_runs_once_least()
        lower_in_few_contexts()
        keep_freed_memory()
        share_programs()


KEPT = 2**30  # [bytes] of programs that stay for the next test run


def forget_oldest(folder: Path, kept: int = KEPT) -> None:
    """Delete those programs in ``folder`` that were written or read longest ago, beyond ``kept`` bytes."""
    found = [(path, path.stat()) for path in folder.glob("*-cache")]
    for path, about in sorted(found, key=lambda each: -max(each[1].st_mtime, each[1].st_atime)):
        kept -= about.st_size
        if kept < 0:
            path.unlink(missing_ok=True)


def pytest_configure(config):
    """Share compiled programs between processes, and with later runs: most of a first run goes into compiling.

    JAX knows a program by its text, by how it is compiled and by its own version: what has changed is compiled anew.
    """
    gc.set_threshold(*RARELY)
    if _SHARED not in os.environ:
        folder = make_private_folder("tests", describe_processor())
        os.environ[_SHARED] = str(folder)
        config.add_cleanup(lambda: forget_oldest(folder))
        config.add_cleanup(lambda: os.environ.pop(_SHARED, None))
    compile_as_tests_do()


def pytest_collection_finish():
    """Leave modules and tests, which live to the end, out of what the garbage collector looks through."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True, scope="module")
def programs_let_go():
    """Release the programs of earlier modules before a process runs out of memory mappings."""
    yield
    programs.release_programs()


ALONE = (".obj", ".ply", ".stl", ".off", ".glb")  # suffixes of meshes that need no other file,
REFERRING = (b"mtllib", b"TextureFile", b'"uri"')  # unless one of these is in them


def sample_once(sample_mesh):
    """`sample_mesh`, but that the last meshes are known by their bytes; what warns is sampled each time."""
    kept: OrderedDict[tuple, Any] = OrderedDict()

    @functools.wraps(sample_mesh)
    def sample(path, **options):
        path = Path(path)
        content = path.read_bytes() if path.suffix in ALONE and path.is_file() else None
        if content is None or any(word in content for word in REFERRING):
            return sample_mesh(path, **options)
        key = (path.suffix, hashlib.sha256(content).digest(), *sorted(options.items()))
        if key in kept:
            return kept[key]
        with warnings.catch_warnings(record=True) as caught:
            sampled = sample_mesh(path, **options)
        for each in caught:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
        if not caught:
            kept[key] = sampled
            if len(kept) > 16:
                kept.popitem(last=False)
        return sampled

    return sample


@pytest.fixture(autouse=True, scope="session")
def meshes_sampled_once():
    """Sample a mesh once for all commands and tests that read it: a run reads its object up to four times."""
    if "trimesh" not in sys.modules:  # which takes long to import: no test here makes a mesh
        yield
        return
    from physagent_jax.scene import mesh

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mesh, "sample_mesh", sample_once(mesh.sample_mesh))
        yield


@pytest.fixture(autouse=True, scope="session")
def parts_found_once():
    """Find the parts of equal particles once: a third of a small run goes into it, and most runs are of one object."""
    from physagent_jax.scene import body

    kept: dict[bytes, Any] = {}
    find_parts = body.find_parts

    def find(points):
        key = hashlib.sha256(points.tobytes()).digest()
        if key not in kept:
            kept[key] = find_parts(points)
        return kept[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(body, "find_parts", find)
        yield


@contextlib.contextmanager
def optimising_least():
    """Compile programs with the fewest optimisations, where compiling takes much longer than running."""
    config: Any = jax.config  # its flags are not typed
    before = config.read("jax_disable_most_optimizations")
    config.update("jax_disable_most_optimizations", True)
    yield
    config.update("jax_disable_most_optimizations", before)


@pytest.fixture
def least_optimised():
    """`optimising_least`, for a test."""
    with optimising_least():
        yield


@pytest.fixture(scope="module")
def module_least_optimised():
    """`optimising_least`, for the tests of a module and for what they share."""
    with optimising_least():
        yield


@pytest.fixture
def quick_plans(monkeypatch):
    """The preset `fast` with few particles in large cells and small pictures; weighing on a coarse grid."""
    fast = PRESETS[PresetName.FAST]
    changes = dict(
        domain=dict(cells=48), filling=dict(max_particles=2500), rendering=dict(width=120, height=90)
    )
    parts = {name: getattr(fast, name).model_copy(update=change) for name, change in changes.items()}
    monkeypatch.setitem(PRESETS, PresetName.FAST, dataclasses.replace(fast, **parts))
    monkeypatch.setattr(burden, "MOST_CELLS", 60)
    monkeypatch.setattr(body, "SHAPE_POINTS", 2500)
    monkeypatch.setattr(body, "SHAPE_CELLS", 24)


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
