"""`physagent doctor`: the state of this installation. It needs no package, so that it can say which is missing."""

from __future__ import annotations

import dataclasses
import json
import textwrap
from typing import TYPE_CHECKING

from physagent_jax.core.errors import UserError

if TYPE_CHECKING:
    from physagent_jax.run.doctor import Cache, Examination, Threads


@dataclasses.dataclass(frozen=True)
class Doctor:
    """Say whether all that a run needs is installed and works, and how to get what is missing.

    Prints versions, devices, kernels, threads, environment variables, caches, the video encoder, free memory and disk,
    and the optional extras. Exit code 2 if a run could not work.
    """

    json: bool = False
    """Print one JSON object instead of sentences."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.cli.environment import prepare
        from physagent_jax.run.doctor import examine

        found = examine(prepare)
        if self.json:
            print(json.dumps(dataclasses.asdict(found), indent=2))
        else:
            print("\n".join(describe_examination(found)))
        if found.problems:
            raise UserError(
                "runs cannot work here: " + "; ".join(each.what.rstrip(".") for each in found.problems),
                do="; ".join(each.do.rstrip(".") for each in found.problems if each.do),
            )
        return 0


def describe_examination(found: Examination) -> list[str]:
    """The examination in lines of text."""
    lines = [
        f"physagent_jax {found.version}, Python {found.python}, {found.system}",
        _row("python", found.interpreter),
    ]
    fine = [f"{each.name} {each.installed}" for each in found.packages if not each.problem]
    lines += _fill("packages", fine)
    lines += [_row("", f"{each.name} {each.problem}") for each in found.packages if each.problem]
    if found.compute is not None:
        lines.append(_row("devices", ", ".join(found.compute.devices)))
        why = f": {found.compute.reason}" if found.compute.reason else ""
        lines.append(_row("kernels", found.compute.kernels + why))
    lines.append(_row("threads", _describe_threads(found.threads)))
    lines += _list(
        "variables", [f"{name}={value}" for name, value in found.variables.items()] or ["none set"]
    )
    lines += _list("caches", [_describe_cache(each) for each in found.caches])
    if found.video is not None:
        lines.append(_row("video", found.video))
    memory = "" if found.free_memory is None else f"{_format_bytes(found.free_memory)} of memory, "
    lines.append(_row("free", f"{memory}{_format_bytes(found.free_disk)} of disk in this folder"))
    lines += _list(
        "extras",
        [
            f"{each.name}: {'complete' if each.command is None else f'lacks {_join(each.missing)}; {each.command}'}"
            for each in found.extras
        ],
    )
    return lines if found.problems else [*lines, "all that a run needs is there"]


def _row(title: str, text: str) -> str:
    return f"{title:<10} {text}"


def _list(title: str, texts: list[str]) -> list[str]:
    return [_row("" if index else title, text) for index, text in enumerate(texts)]


def _fill(title: str, words: list[str], width: int = 90) -> list[str]:
    """Words in lines of at most ``width`` characters."""
    return _list(title, textwrap.wrap(", ".join(words), width, break_on_hyphens=False)) if words else []


def _join(words: tuple[str, ...]) -> str:
    return ", ".join(words)


def _describe_threads(threads: Threads) -> str:
    text = f"{threads.usable} of {threads.cores} cores may be used"
    if threads.quota is not None and threads.quota < threads.usable:
        text += f", but a container's limit amounts to {threads.quota:g} (set NUMBA_NUM_THREADS)"
    return text if threads.kernels is None else f"{text}; kernels take {threads.kernels}"


def _describe_cache(cache: Cache) -> str:
    if cache.folder is None:
        return f"{cache.name}: not kept between processes"
    count = f"{cache.count}" if cache.total is None else f"{cache.count} of {cache.total}"
    state = "" if cache.writable else ", not writable"
    return f"{cache.name}: {count}, {_format_bytes(cache.size)}{state}, {cache.folder}"


def _format_bytes(size: int) -> str:
    for unit, scale in (("GB", 1e9), ("MB", 1e6)):
        if size >= scale:
            return f"{size / scale:.3g} {unit}"
    return f"{size / 1e3:.3g} kB"
