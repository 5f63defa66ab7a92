"""Object cards, beside an object whose name may be odd too."""

from __future__ import annotations

from pathlib import Path

from physagent_jax.scene.card import ObjectCard, load_card
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw, altered, any_json, damaged, encoded, of_schema

GOOD = {"name": "loaf", "kind": "food", "up": "+z", "azimuth_degrees": 30.0, "credit": "made by hand"}
NAMES = ("object", "a b", "ü", "x.y", "-", "機器人")


def make(draw: Draw) -> Case:
    """One card, read."""
    name = draw.one(NAMES)
    match draw.one(["altered", "altered", "damaged", "schema", "any"]):
        case "altered":
            what, content = altered(draw, GOOD)
        case "damaged":
            what, content = damaged(draw, encoded(GOOD))
        case "schema":
            what, content = "of the schema", encoded(of_schema(draw, ObjectCard.model_json_schema()))
        case _:
            what, content = "any JSON", encoded(any_json(draw))
    return Case(what, lambda folder: _load(folder, name), {f"{name}.card.json": content})


def _load(folder: Path, name: str):
    return load_card(folder / f"{name}.ply")
