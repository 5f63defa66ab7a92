"""Score priors: video models, and a toy one, that say how pixels should change to fit a sentence."""

from __future__ import annotations

import importlib
from typing import Any

from baselines.scores.protocol import Cost as Cost
from baselines.scores.protocol import ScorePrior as ScorePrior
from baselines.scores.sds import SdsSettings as SdsSettings
from physagent_jax.core.errors import UserError

_PLACES = {
    "wan": ("wan", "WanPrior"),
    "modelscope": ("modelscope", "ModelScopePrior"),
    "cogvideox": ("cogvideox", "CogVideoXPrior"),
    "toy": ("toy.prior", "ToyPrior"),
}
"""Where each prior is; the first is the default of the real ones."""

PRIORS = tuple(_PLACES)


def open_prior(name: str, weights: str, **options: Any) -> ScorePrior:
    """Loads a prior.

    Args:
        name: One of `PRIORS`.
        weights: Folder, or for a real prior also a hub id.
        options: Of its class's `load`.

    Raises:
        UserError: There is no such prior, its extra is not installed, or its weights are not there or not fit for use.
    """
    if name not in _PLACES:
        raise UserError("there is no such score prior", got=name, do=f"Take one of {', '.join(PRIORS)}")
    module, kind = _PLACES[name]
    return getattr(importlib.import_module(f"baselines.scores.{module}"), kind).load(weights, **options)
