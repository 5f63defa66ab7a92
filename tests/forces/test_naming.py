"""Entries of a force field are named for people by skill and words."""

import pytest

from physagent_jax.forces.naming import name_places
from physagent_jax.forces.schema import Action, ConstraintType, ForceField, VelocityConstraint

FIELD = ForceField(
    actions=(
        Action(action_type="translation", vector=(1, 0, 0), magnitude=1.0),
        Action(action_type="torque", vector=(0, 0, 1), magnitude=1.0),
        Action(action_type="translation", vector=(0, 1, 0), magnitude=1.0),
    ),
    constraints=(
        VelocityConstraint(
            constraint_type=ConstraintType("enforce_particle_rotation"), vector=(0, 0, 1), magnitude=1.0
        ),
    ),
)


@pytest.mark.parametrize(
    "text, named",
    [
        (
            "decrease the magnitude of actions[1] by a factor of 2",
            "decrease the magnitude of the torque by a factor of 2",
        ),
        (
            "turn actions[0].vector, keep actions[2]",
            "turn the direction of the first translation, keep the second translation",
        ),
        ("constraints[0].active_time is longer", "the time of the particle rotation is longer"),
        ("actions[9]", "the 10th action"),
        ("turn actions[0], actions[1], actions[2], constraints[0]", "turn the first translation and 3 more"),
        ("transactions [0] and actions", "transactions [0] and actions"),
    ],
)
def test_places_become_skills(text, named):
    assert name_places(text, FIELD) == named


def test_without_a_force_field_an_action_is_counted():
    assert (
        name_places("increase constraints[0].magnitude", None)
        == "increase the magnitude of the first constraint"
    )


def test_the_words_that_led_to_an_action_follow_its_name():
    named = name_places("actions[1].magnitude is too small", FIELD, {"actions[1]": "spin it"})
    assert named == "the magnitude of the torque \u2018spin it\u2019 is too small"
