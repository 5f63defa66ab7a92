"""The command line in a process that something happens to when it has written its n-th file.

    python -m tests.fuzz.interrupted WHAT N [MARKER] -- run --object ...

WHAT: "none"; "before", "after" (kill -9 just before or after the rename that puts the file there); "int", "term" (a
signal then); "int2", "term2" (and another a moment later); "hold" (waits there until MARKER, which it makes, is gone);
"readonly" (--out may not be written to from then on).
Only files within --out count; those that replace a file at its own name all the same.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from physagent_jax.cli import main

_SIGNALS = {"int": signal.SIGINT, "term": signal.SIGTERM}


def happen(what: str, marker: str, out: str) -> None:
    """Whatever it is, now."""
    match what:
        case "before" | "after":
            os.kill(os.getpid(), signal.SIGKILL)
        case "int" | "term":
            os.kill(os.getpid(), _SIGNALS[what])
        case "int2" | "term2":
            number = _SIGNALS[what[:-1]]
            os.kill(os.getpid(), number)
            threading.Timer(0.05, os.kill, (os.getpid(), number)).start()
        case "hold":
            Path(marker).touch()
            while Path(marker).exists():
                time.sleep(0.02)
        case "readonly" if os.geteuid() == 0:  # whom no permission holds
            subprocess.run(["mount", "--bind", out, out], check=True)
            subprocess.run(["mount", "-o", "remount,bind,ro", out], check=True)
        case "readonly":
            for folder, _, _ in os.walk(out):
                os.chmod(folder, 0o500)


def watched(what: str, at: int, marker: str, out: str) -> None:
    """Count the files that are put in place within ``out``."""
    count, replace, within = 0, os.replace, os.path.abspath(out)

    def counting(source, target, *args, **kwargs):
        nonlocal count
        ours = os.path.abspath(os.fspath(target)).startswith(within)
        count += ours
        now = ours and count == at
        if now and what == "before":
            happen(what, marker, out)
        result = replace(source, target, *args, **kwargs)
        if now and what != "before":
            happen(what, marker, out)
        return result

    os.replace = counting
    os.rename = counting


if __name__ == "__main__":
    split = sys.argv.index("--")
    what, at, *marker = sys.argv[1:split]
    arguments = sys.argv[split + 1 :]
    watched(what, int(at), "".join(marker), arguments[arguments.index("--out") + 1])
    sys.argv = ["physagent", *arguments]
    sys.exit(main())
