"""Every number that comes from outside has a range, and every range keeps out what float32 cannot compute with."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField, SkillScaling
from physagent_jax.motion.schema import Judgement, SceneBrief
from physagent_jax.perception.schema import MotionReport
from physagent_jax.run.spec import PerceptionChoice
from physagent_jax.scene import config as c
from physagent_jax.scene.card import ObjectCard

INPUTS = [c.SceneConfig, ForceField, SkillScaling, ObjectCard, SceneBrief, SemanticReply, Judgement, Rewrite]


def numbers(schema, place=""):
    """(place, schema) of every number in a JSON schema."""
    if isinstance(schema, dict):
        if schema.get("type") in ("number", "integer") and "const" not in schema and "enum" not in schema:
            yield place, schema
        for key, value in schema.items():
            yield from numbers(value, f"{place}/{key}")
    elif isinstance(schema, list):
        for index, value in enumerate(schema):
            yield from numbers(value, f"{place}/{index}")


@pytest.mark.parametrize("model", [*INPUTS, PerceptionChoice, MotionReport], ids=lambda model: model.__name__)
def test_every_number_of_every_schema_has_its_range(model: type[BaseModel]):
    """The magnitude of an action is checked by its own rule, and is the one exception."""
    found = list(numbers(model.model_json_schema()))
    assert found
    for place, schema in found:
        if place.endswith("properties/magnitude"):
            continue
        low = schema.get("minimum", schema.get("exclusiveMinimum"))
        high = schema.get("maximum", schema.get("exclusiveMaximum"))
        assert low is not None and high is not None, place
        assert -1e30 <= low < high <= 1e30, place


def lists(schema, place=""):
    if isinstance(schema, dict):
        if schema.get("type") == "array" and "prefixItems" not in schema:
            yield place, schema
        for key, value in schema.items():
            yield from lists(value, f"{place}/{key}")
    elif isinstance(schema, list):
        for index, value in enumerate(schema):
            yield from lists(value, f"{place}/{index}")


def test_every_list_of_a_scene_has_a_length():
    for place, schema in lists(c.SceneConfig.model_json_schema()):
        assert schema.get("maxItems", math.inf) <= 256, place


EXTREME = [1e-300, 1e30, 1e300, -1e300]
BASE = {"source": {"path": "x.ply"}}


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"timing": {"frame_dt": 1e-300}}, "timing.frame_dt"),
        ({"timing": {"substep_dt": 1e-300}}, "timing.substep_dt"),
        ({"domain": {"size": 1e-300}}, "domain.size"),
        ({"material": {"youngs_modulus": 1e-300}}, "material.youngs_modulus"),
        ({"material": {"density": 1e-300}}, "material.density"),
        ({"material": {"model": "fluid", "bulk_modulus": 1e-300}}, "got 1.2"),
        ({"gravity": [0, 0, 1e30]}, "gravity.2"),
        ({"transfer": {"damping_rate": 1e300}}, "transfer.damping_rate"),
        ({"camera": {"distance": 1e-300}}, "camera.distance"),
        ({"camera": {"azimuth_degrees": 1e300}}, "camera.azimuth_degrees"),
        ({"rendering": {"background": [0, 0, 7]}}, "rendering.background.2"),
        ({"source": {"path": "x", "extent": 1e-300}}, "source.extent"),
        ({"source": {"path": "x", "crop": [1, 0, 0, 1, 0, 1]}}, "`crop` must be"),
        ({"source": {"path": "x" * 5000}}, "source.path"),
        ({"filling": {"seed": -1}}, "filling.seed"),
        ({"filling": {"seed": 2**32}}, "filling.seed"),
        ({"boundaries": [{"kind": "sphere", "point": [0, 0, 0], "radius": 1e-300}]}, "radius"),
        ({"boundaries": [{"kind": "half_space", "point": [0] * 3, "normal": [1e300, 0, 0]}]}, "normal"),
        ({"boundaries": [{"kind": "half_space", "point": [0] * 3, "normal": [0, 0, 1], "friction": -1}]},
         "friction"),
        ({"boundaries": [{"kind": "half_space", "point": [0] * 3, "normal": [0, 0, 1], "end": 1e-300}]},
         "too short"),
        ({"boundaries": [{"kind": "half_space", "point": [0] * 3, "normal": [0, 0, 1], "start": 1e8,
                          "end": 1e8 + 1}]}, "too short"),
        ({"boundaries": [{"kind": "half_space", "point": [0] * 3, "normal": [0, 0, 1]}] * 300}, "boundaries"),
        ({"constraints": [{"kind": "particle_impulse", "point": [1] * 3, "half_size": [1] * 3,
                           "force": [1, 0, 0], "duration": 1e-300}]}, "duration"),
        ({"constraints": [{"kind": "particle_impulse", "point": [1] * 3, "half_size": [-1, 1, 1],
                           "force": [1, 0, 0]}]}, "half_size.0"),
        ({"forces": [{"kind": "attractor", "point": [1] * 3, "strength": 1e30}]}, "strength"),
        ({"forces": [{"kind": "attractor", "point": [1] * 3, "strength": 1e5, "softening": 1e-5,
                      "power": 6}]}, "softening"),
        ({"forces": [{"kind": "uniform", "acceleration": [1, 0, 0],
                      "envelope": {"kind": "ramp", "rise": 1e-300}}]}, "rise"),
        ({"force_field": {"actions": [{"action_type": "impulse", "vector": [1, 0, 0],
                                       "active_time": [0, 1e-300]}]}}, "too short"),
        ({"preset": "fast", "meterial": {}}, "`material`"),
        ({"transfer": {"scheme": "apik"}}, "`apic`"),
        ({"anchor": {"kind": "bass"}}, "`base`"),
        ({"material": {"model": "neo_hokean"}}, "`neo_hookean`"),
    ],
)  # fmt: skip
def test_what_float32_cannot_compute_with_is_refused_by_name(change, field):
    with pytest.raises(UserError) as error:
        c.parse_scene(BASE | change, origin="scene.json")
    assert field in str(error.value), str(error.value)


def leaves(data, place=()):
    if isinstance(data, dict):
        for key, value in data.items():
            yield from leaves(value, (*place, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from leaves(value, (*place, index))
    elif isinstance(data, int | float) and not isinstance(data, bool):
        yield place, data


FULL = json.loads(
    c.dump_scene(
        c.SceneConfig.model_validate(
            {
                "source": {
                    "path": "x.ply",
                    "crop": [0, 1, 0, 1, 0, 1],
                    "center": [2, 2, 2],
                    "rotation_degrees": [10],
                    "rotation_axes": [0],
                },
                "material": {"model": "snow"},
                "material_regions": [{"point": [1, 1, 1], "half_size": [1, 1, 1], "material": {}}],
                "boundaries": [
                    {"kind": "sphere", "point": [1, 1, 1], "radius": 1},
                    {"kind": "mesh", "path": "x.obj", "rotation_degrees": [10], "rotation_axes": [1]},
                    {"kind": "cuboid", "point": [1, 1, 1], "half_size": [1, 1, 1], "end": 2},
                ],
                "constraints": [
                    {
                        "kind": "particle_rotation",
                        "point": [1, 1, 1],
                        "normal": [0, 0, 1],
                        "half_height": 1,
                        "radius": 1,
                    },
                    {
                        "kind": "particle_impulse",
                        "point": [1, 1, 1],
                        "half_size": [1, 1, 1],
                        "force": [1, 0, 0],
                    },
                    {
                        "kind": "particle_release",
                        "normal": [0, 0, 1],
                        "start_position": 0,
                        "end_position": 1,
                        "layers": 3,
                    },
                ],
                "forces": [
                    {
                        "kind": "wind",
                        "direction": [1, 0, 0],
                        "linear_drag": 1,
                        "envelope": {"kind": "ramp", "rise": 0.1, "fall": 0.1, "end": 1},
                    },
                    {
                        "kind": "attractor",
                        "point": [1, 1, 1],
                        "strength": 1,
                        "envelope": {"kind": "sine", "frequency": 2},
                    },
                    {"kind": "turbulence", "strength": 1, "length_scale": 1, "time_scale": 1},
                ],
                "force_field": {
                    "actions": [
                        {
                            "action_type": "scale",
                            "vector": [1, 0, 0],
                            "active_time": [0, 3],
                            "region": {"kind": "sphere", "center": [0, 0, 0], "radius": 1},
                        }
                    ]
                },
                "camera": {"target": [1, 1, 1]},
            }  # fmt: skip
        )
    )
)
PLACES = [place for place, _ in leaves(FULL)]


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(PLACES), st.one_of(st.sampled_from(EXTREME), st.floats(), st.integers()))
def test_any_number_in_any_field_is_accepted_or_refused_in_one_line(place, value):
    """And what is accepted is nothing that squares to infinity, nor, where it may divide, to zero."""
    data = json.loads(json.dumps(FULL))
    *parents, last = place
    at = data
    for key in parents:
        at = at[key]
    at[last] = value
    try:
        config = c.parse_scene(data)
    except UserError as error:
        assert "\n" not in str(error) and len(str(error)) < 700
        return
    for _, number in leaves(json.loads(c.dump_scene(config))):
        assert abs(number) <= 1e16 and math.isfinite(number)


def test_seeds_and_directions_say_what_they_must_be():
    with pytest.raises(ValidationError, match="greater than or equal to 0"):
        c.Filling(seed=-3)
    with pytest.raises(ValidationError, match="zero vector"):
        c.HalfSpace(point=(0, 0, 0), normal=(0, 0, 1e-10))
