"""The skill library's description: made from the schema, complete, readable without arrays."""

import json
import subprocess
import sys

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField, VelocityConstraint


def test_the_text_names_every_skill_field_and_limit():
    text = describe_skills().text
    names = [*ActionType, *ConstraintType, *Action.model_fields, *VelocityConstraint.model_fields]
    for name in (*names, *ForceField.model_fields):
        assert f"`{name}`" in text
    assert str(MAGNITUDE_MIN) in text and str(MAGNITUDE_MAX) in text


def test_its_example_is_a_force_field():
    example = describe_skills().text.split("An example: ")[1]
    assert ForceField.model_validate_json(example).actions


def test_the_schema_is_that_of_a_force_field():
    schema = json.loads(json.dumps(describe_skills().json_schema))
    assert set(schema["properties"]) == set(ForceField.model_fields)
    assert schema["additionalProperties"] is False


def test_it_needs_no_arrays():
    code = "import sys, physagent_jax.forces.description; sys.exit(bool({'jax', 'numpy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
