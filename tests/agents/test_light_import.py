"""The agents' layer holds no arrays: importing all of it loads neither jax nor numpy."""

import subprocess
import sys

PROGRAM = """
import importlib, pkgutil, sys
import physagent_jax.agents as package
names = [m.name for m in pkgutil.walk_packages(package.__path__, package.__name__ + ".")]
for name in names:
    importlib.import_module(name)
heavy = sorted({m.split(".")[0] for m in sys.modules} & {"jax", "jaxlib", "numpy", "scipy", "torch"})
print(len(names), *heavy)
"""


def test_agents_import_without_arrays():
    """A fresh interpreter imports every module of the package and has no array library in it."""
    result = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    count, *heavy = result.stdout.split()
    assert int(count) > 15
    assert heavy == []
