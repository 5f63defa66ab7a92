"""Python in processes of their own, with this repository's packages and a time limit."""

import os
import subprocess
import sys

from tests.conftest import QUICK_TO_COMPILE, RARELY, REPOSITORY

QUICKLY = {
    "XLA_FLAGS": f"{os.environ.get('XLA_FLAGS', '')} {QUICK_TO_COMPILE}".strip(),
    "JAX_DISABLE_MOST_OPTIMIZATIONS": "1",
}
"""Variables of a process in which compiling takes longer than running."""
LIMIT = 240  # [s]; what hangs would do so for ever


def begun(script, **environment):
    """A process that runs ``script``, and seldom looks for garbage."""
    return subprocess.Popen(
        [sys.executable, "-c", f"import gc\ngc.set_threshold(*{RARELY})\n{script}"],
        cwd=REPOSITORY,
        env=os.environ | {"PYTHONPATH": str(REPOSITORY)} | environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process):
    """Its exit code, and what it wrote; a process that does not end fails the test."""
    try:
        out, err = process.communicate(timeout=LIMIT)
    finally:
        process.kill()
    return process.returncode, out, err


def ran(script, **environment):
    """`ended` of `begun`."""
    return ended(begun(script, **environment))
