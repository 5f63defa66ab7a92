"""Agents, chat models and the judge of motion hold no arrays: importing them loads neither jax nor numpy."""

import subprocess
import sys

PROGRAM = """
import importlib, pkgutil, sys
layers = [importlib.import_module(f"physagent_jax.{layer}") for layer in ("agents", "chat", "motion")]
names = [m.name for layer in layers for m in pkgutil.walk_packages(layer.__path__, layer.__name__ + ".")]
for name in names:
    importlib.import_module(name)
heavy = sorted({m.split(".")[0] for m in sys.modules} & {"jax", "jaxlib", "numpy", "scipy", "torch"})
print(len(names), *heavy)
"""


def test_agents_import_without_arrays():
    """A fresh interpreter imports every module of the layers and has no array library in it."""
    result = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    count, *heavy = result.stdout.split()
    assert int(count) > 15
    assert heavy == []
