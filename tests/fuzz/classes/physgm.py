"""PhysGM's predictions."""

from __future__ import annotations

from pathlib import Path

from physagent_jax.core.reading import read_json
from physagent_jax.scene.physgm import CLASSES, import_physgm
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw, altered, any_json, damaged, encoded

NAME = "predicted_phys.json"


def make(draw: Draw) -> Case:
    """One prediction, decoded or as the network's own outputs."""
    name = draw.one(sorted(CLASSES))
    good: dict = draw.one(
        [
            {"E": 2.4e6, "nu": 0.398, "material": name},
            {"E_mu": 0.1, "nu_mu": -0.2, "material": name},
            {"E_mu": 0.1, "nu_mu": -0.2, "phys_logits": [0.1 * i for i in range(14)]},
        ]
    )
    match draw.one(["altered", "altered", "altered", "numbers", "numbers", "damaged", "any"]):
        case "altered":
            what, content = altered(draw, good)
        case "numbers":
            changed = good | {key: draw.number() for key in good if key[0] in "En"}
            what, content = "other numbers", encoded(changed)
        case "damaged":
            what, content = damaged(draw, encoded(good))
        case _:
            what, content = "any JSON", encoded(any_json(draw))
    return Case(what, _import, {NAME: content})


def _import(folder: Path):
    return import_physgm(read_json(folder / NAME))
