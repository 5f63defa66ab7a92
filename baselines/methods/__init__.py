"""The methods by name; each is imported when it is chosen, with whatever package it needs."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from baselines.protocol import Method
from physagent_jax.core.errors import UserError
from physagent_jax.core.registry import Registry

METHODS = Registry(
    "`--method`",
    {
        "expert": "baselines.methods.expert:Expert",
        "random": "baselines.methods.random:RandomSearch",
        "cma": "baselines.methods.cma:CMA",
        "catcma": "baselines.methods.catcma:CatCMA",
        "adam": "baselines.methods.adam:Adam",
        "lbfgs": "baselines.methods.lbfgs:LBFGS",
        "levenberg_marquardt": "baselines.methods.levenberg_marquardt:LevenbergMarquardt",
        "smoothed_adam": "baselines.methods.smoothed_adam:SmoothedAdam",
        "bo_leap": "baselines.methods.bo_leap:BOLeap",
        "direction_only": "baselines.methods.direction_only:DirectionOnly",
        "rules": "baselines.methods.rules:Rules",
        "chat_agents": "baselines.methods.chat_agents:ChatAgents",
        "sds_last_substep": "baselines.methods.sds_steps:SdsLastSubstep",
        "sds_whole_clip": "baselines.methods.sds_steps:SdsWholeClip",
        "sds_choice": "baselines.methods.sds_choice:SdsChoice",
        "clip_guided": "baselines.methods.clip_guided:ClipGuided",
        "hybrid": "baselines.methods.hybrid:Hybrid",
    },
)


def make_method(
    name: str, options: Mapping[str, Any] | None = None, hidden: Sequence[Path] | None = None
) -> Method:
    """The method of this name with these options.

    Args:
        name: A name of `METHODS`; or ``module:Class`` or ``file.py:Class``, for a method of one's own.
        options: Options of the method.
        hidden: Files that a method of one's own must not read: it runs behind a `door`, in a process of its own. None =
            it runs in this one.

    Raises:
        UserError: There is none, it is no method, it has no such options, or they are out of range.
    """
    if ":" not in name:
        return METHODS.make((name, options or {}))
    if hidden is not None:
        from baselines.door import ClosedMethod

        return ClosedMethod(name, options or {}, tuple(hidden))
    place, _, attribute = name.rpartition(":")
    module = _load_file(Path(place)) if place.endswith(".py") else place
    try:
        method = Registry(METHODS.what, {name: f"{module}:{attribute}"}).make((name, options or {}))
    except AttributeError:
        raise UserError(f"{place} has no such method", got=attribute, do="Name a class of it") from None
    if not isinstance(method, Method):
        raise UserError(f"{name} is not a method", do="Derive it from baselines.protocol.Method")
    return method


def _load_file(path: Path) -> str:
    """Name of the module that a file is, once loaded: no other module has it."""
    name = f"method_{hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None or not path.is_file():
            raise UserError("there is no file of a method", got=path, do="Give FILE.py:Class")
        module = sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return name
