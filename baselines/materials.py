"""Materials that a task can be given in place of its own.

What a force field does depends on what it acts on. A method can be run with any material, and a force field that was
found with one be tried with another: in the PhysAgent paper "X + PhysAgent" is a force field of the agents' for the
material of another method.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from baselines.objects import TaskObject
from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name
from physagent_jax.scene.config import MaterialModel
from physagent_jax.scene.materials.library import LIBRARY

OWN = "own"

Material = str | Mapping[str, Any] | None
"""As `physagent_jax.build_scene` takes it."""


def _scale_stiffness(factor: float) -> Callable[[TaskObject], Material]:
    return lambda thing: thing.material | dict(youngs_modulus=factor * thing.youngs_modulus)


SETTINGS: Mapping[str, Callable[[TaskObject], Material]] = {
    OWN: lambda thing: thing.material,
    "implied": lambda thing: None,
    "softer": _scale_stiffness(1 / 3),
    "stiffer": _scale_stiffness(3.0),
    "omniphysgs": lambda thing: thing.material | dict(youngs_modulus=2e6, poissons_ratio=0.4),
}
"""By name: the task's own; what the object's kind implies, as for a user who says nothing; a third of E, three times E;
the E and nu that OmniPhysGS fixes (buffers of `elasticity.py`, `plasticity.py`), which chooses laws and no numbers."""


def choose_material(setting: str, thing: TaskObject) -> Material:
    """The material of an object.

    Args:
        setting: One of `SETTINGS`, a named material, a constitutive model, or a JSON object of fields.
        thing: The object.

    Raises:
        UserError: It is none of these.
    """
    if setting in SETTINGS:
        return SETTINGS[setting](thing)
    if setting.lstrip().startswith("{"):
        try:
            fields = json.loads(setting)
        except json.JSONDecodeError as error:
            raise UserError(f"the material is not a JSON object: {error}", got=setting) from None
        return thing.material | fields
    named = (*LIBRARY, *MaterialModel)
    if setting in named:
        return setting
    raise explain_unknown_name("the material", setting, (*SETTINGS, *named))
