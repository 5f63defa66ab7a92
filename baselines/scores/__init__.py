"""Score priors: video models, and a toy one, that say how pixels should change to fit a sentence."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping
from typing import Any

from baselines.scores.protocol import Cost as Cost
from baselines.scores.protocol import ScorePrior as ScorePrior
from baselines.scores.sds import SdsSettings as SdsSettings
from baselines.scores.sds import Weighting
from physagent_jax.core.errors import UserError

_PLACES = {
    "wan": ("wan", "WanPrior"),
    "modelscope": ("modelscope", "ModelScopePrior"),
    "cogvideox": ("cogvideox", "CogVideoXPrior"),
    "toy": ("toy.prior", "ToyPrior"),
}
"""Module and class of each prior; the first is the default of the real ones."""

PRIORS = tuple(_PLACES)


def open_prior(name: str, weights: str, **options: Any) -> ScorePrior:
    """Load a prior.

    Args:
        name: One of `PRIORS`.
        weights: Folder, or for a real prior also a hub id.
        options: Options of its class's `load`; ``settings`` may be a mapping of some fields of `SdsSettings`,
            the others are
            the prior's own.

    Raises:
        UserError: There is no such prior, its extra is not installed, or its weights are not there or not fit for use.
    """
    if name not in _PLACES:
        raise UserError("there is no such score prior", got=name, do=f"Take one of {', '.join(PRIORS)}")
    module, attribute = _PLACES[name]
    kind = getattr(importlib.import_module(f"baselines.scores.{module}"), attribute)
    if isinstance(changes := options.get("settings"), Mapping):
        options["settings"] = change_settings(kind.default_settings, changes)
    return kind.load(weights, **options)


def change_settings(settings: SdsSettings, changes: Mapping[str, Any]) -> SdsSettings:
    """The settings with other values, as JSON has them.

    Raises:
        UserError: There is no such field, or a value is out of range.
    """
    known = [field.name for field in dataclasses.fields(SdsSettings)]
    if unknown := [name for name in changes if name not in known]:
        raise UserError("there are no such settings", got=", ".join(unknown), do=f"Take {', '.join(known)}")
    values = dict(changes)
    if "weighting" in values:
        if values["weighting"] not in list(Weighting):
            raise UserError("`weighting` must be one of " + ", ".join(Weighting), got=values["weighting"])
        values["weighting"] = Weighting(values["weighting"])
    return dataclasses.replace(settings, **values)
