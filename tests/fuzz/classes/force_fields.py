"""Force field JSON, compiled on a few particles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from physagent_jax.core.reading import read_model
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField
from tests.fuzz.classes.scenes import ACTIONS, HELD, REGIONS
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw, altered, damaged, encoded, of_schema

NAME = "force_field.json"
FRAMES, FRAME_DT = 9, 0.04


def make(draw: Draw) -> Case:
    """One force field."""
    actions = [
        {**draw.one(ACTIONS), "region": draw.one(REGIONS), "object": None} for _ in range(draw.one([1, 1, 2]))
    ]
    good = {
        "default_drop": False,
        "actions": actions,
        "constraints": [draw.one(HELD)] if draw.chance(0.5) else [],
    }
    match draw.one(["altered"] * 4 + ["damaged", "schema", "schema"]):
        case "altered":
            what, content = altered(draw, good)
        case "damaged":
            what, content = damaged(draw, encoded(good))
        case _:
            what, content = "of the schema", encoded(of_schema(draw, ForceField.model_json_schema()))
    body = draw.one(["usual", "usual", "usual", "one particle", "a line", "a point"])
    return Case(f"{what}; {body}", lambda f: _compile(f, body), {NAME: content})


def _compile(folder: Path, body: str):
    field = read_model(folder / NAME, ForceField)
    rest = np.random.default_rng(0).uniform(0.5, 1.5, (20, 3)).astype(np.float32)
    if body == "one particle":
        rest = rest[:1]
    elif body == "a line":
        rest[:, 1:] = 1.0
    elif body == "a point":
        rest[:] = 1.0
    scaling = make_closed_form_scaling(
        extent=1.0, youngs_modulus=1e5, density=200.0, duration=(FRAMES - 1) * FRAME_DT
    )
    volume = np.full(len(rest), 1e-3, np.float32)
    again = ForceField.model_validate_json(field.model_dump_json())
    return field, compile_force_field(again, scaling, rest, volume, frame_dt=FRAME_DT, frame_count=FRAMES)
