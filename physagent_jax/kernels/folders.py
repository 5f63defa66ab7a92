"""Folders for compiled code: private to the user, and made for this processor.

Whoever can write there has his code run by us, so that a folder that others own or may write to is not used at all;
and code compiled for a processor with other instructions ends in SIGILL, so that each kind has its own folder.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import stat
import tempfile
from functools import cache
from pathlib import Path

log = logging.getLogger(__name__)
_ABOUT_THE_CPU = ("model name", "flags", "features", "cpu implementer", "cpu part")  # in /proc/cpuinfo


def make_private_folder(*parts: str, base: Path | None = None) -> Path:
    """The folder ``parts`` of the user's cache, or of ``base``; made if it is not there.

    Where that is impossible, or would not be private, one in the folder for temporary files serves, and if that is
    somebody else's too, a new one that nobody finds again.
    """
    folder = (base or _find_user_folder()).joinpath(*parts)
    if is_usable(folder):
        return folder
    user = os.geteuid() if hasattr(os, "geteuid") else "user"
    shared = Path(tempfile.gettempdir()) / f"physagent_jax-{user}"  # anybody may have made it before us
    if is_usable(shared) and is_usable(shared.joinpath(*parts)):
        return shared.joinpath(*parts)
    return Path(tempfile.mkdtemp(prefix="physagent-"))


def is_usable(folder: Path) -> bool:
    """Return whether ``folder`` could be made, is ours alone and can be written to."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        folder.mkdir(exist_ok=True, mode=0o700)
        found = folder.lstat()
    except OSError:
        return False
    if not stat.S_ISDIR(found.st_mode) or not os.access(folder, os.W_OK | os.X_OK):
        return False
    if hasattr(os, "geteuid") and (found.st_uid != os.geteuid() or found.st_mode & 0o022):
        log.warning("%s belongs to others or may be written by them: it is not used", folder)
        return False
    return True


def _find_user_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME")
    return Path(base or os.path.expanduser("~/.cache")) / "physagent_jax"


@cache
def describe_processor() -> str:
    """A short name for this kind of processor and what it can do."""
    try:
        lines = Path("/proc/cpuinfo").read_text(errors="replace").split("\n\n")[0].splitlines()
        known = [line for line in lines if line.lower().startswith(_ABOUT_THE_CPU)]
    except OSError:
        known = [platform.processor()]
    return hashlib.sha256("\n".join([platform.machine(), *known]).encode()).hexdigest()[:12]
