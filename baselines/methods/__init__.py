"""The methods by name; each is imported when it is chosen, with whatever package it needs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from baselines.protocol import Method
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
        "physsplat_f": "baselines.methods.physsplat_f:PhysSplatF",
        "physagent": "baselines.methods.physagent:PhysAgent",
        "dreamphysics_f": "baselines.methods.dreamphysics_f:DreamPhysicsF",
        "omniphysgs_f": "baselines.methods.omniphysgs_f:OmniPhysGSF",
        "clip_guided": "baselines.methods.clip_guided:ClipGuided",
        "hybrid": "baselines.methods.hybrid:Hybrid",
    },
)


def make_method(name: str, options: Mapping[str, Any] | None = None) -> Method:
    """The method of this name with these options.

    Raises:
        UserError: There is none, it has no such options, or they are out of range.
    """
    return METHODS.make((name, options or {}))
