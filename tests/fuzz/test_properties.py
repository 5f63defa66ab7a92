"""The same contract for inputs that hypothesis makes, and makes small again where one of them fails."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from physagent_jax.core.reading import decode_json, read_model
from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians import read_ply
from physagent_jax.scene.config import load_scene
from physagent_jax.scene.physgaussian import import_physgaussian
from physagent_jax.scene.physgm import import_physgm
from tests.agents.scenes import brief
from tests.fuzz import seeds
from tests.fuzz.classes import prompts, scenes
from tests.fuzz.contract import Case, Outcome, check

EXAMPLES = settings(
    max_examples=150, derandomize=True, database=None, deadline=None, suppress_health_check=list(HealthCheck)
)
NUMBERS = st.one_of(st.integers(), st.floats(allow_nan=False, allow_infinity=False))
JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), NUMBERS, st.text(max_size=8)),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4),
    max_leaves=15,
)


def held(case: Case) -> None:
    """The contract holds for one case."""
    with tempfile.TemporaryDirectory() as folder:
        result = check(case, Path(folder))
    assert result.outcome is not Outcome.FAILED, (result, case.what)


@EXAMPLES
@given(st.text(max_size=80))
def test_any_text_is_a_sentence_or_refused(text):
    held(Case(text, lambda _: prompts.looped(text, brief(), {})))


@EXAMPLES
@given(
    st.lists(
        st.sampled_from([*prompts.VERBS, *prompts.HOW, *prompts.WHERE, *prompts.WHEN, *prompts.JOIN]),
        max_size=12,
    )
)
def test_any_words_of_the_language_are_a_sentence_or_refused(words):
    held(Case(str(words), lambda _: prompts.looped(" ".join(words), brief(), {})))


@EXAMPLES
@given(st.binary(max_size=300))
def test_any_bytes_are_json_or_refused(data):
    held(Case(repr(data), lambda _: decode_json(data, "the file")))


@EXAMPLES
@given(st.binary(max_size=300), st.sampled_from([0, 1, 5, 2**40]))
def test_any_bytes_after_a_header_are_gaussians_or_refused(data, count):
    begin, rest = seeds.gaussians(12).split(b"element vertex 12\n")
    header = begin + b"element vertex %d\n" % count + rest[: rest.index(b"end_header\n") + 11]
    held(Case(repr(data), lambda folder: read_ply(folder / "x.ply"), {"x.ply": header + data}))


@EXAMPLES
@given(st.dictionaries(st.sampled_from(["E", "nu", "material", "E_mu", "nu_mu", "phys_logits"]), JSON))
def test_any_json_is_a_prediction_or_refused(data):
    held(Case(repr(data), lambda _: import_physgm(data)))


@EXAMPLES
@given(
    st.dictionaries(
        st.sampled_from(
            ["n_grid", "grid_lim", "g", "substep_dt", "frame_num", "boundary_conditions", "E", "scale"]
        ),
        JSON,
    )
)
def test_any_json_is_a_physgaussian_scene_or_refused(data):
    held(Case(repr(data), lambda _: import_physgaussian(data, object_path="x.ply")))


@EXAMPLES
@given(st.lists(NUMBERS, min_size=3, max_size=3), NUMBERS, st.lists(NUMBERS, min_size=2, max_size=2))
def test_any_numbers_are_an_action_or_refused(vector, magnitude, window):
    action = {"action_type": "torque", "vector": vector, "magnitude": magnitude, "active_time": window}
    text = json.dumps({"actions": [action]}).encode()
    held(Case(repr(action), lambda folder: read_model(folder / "f.json", ForceField), {"f.json": text}))


@EXAMPLES
@given(
    st.sampled_from(["gravity", "timing", "camera", "domain", "filling", "transfer", "material", "anchor"]),
    JSON,
)
def test_any_json_in_a_part_of_a_scene_is_read_or_refused(part, data):
    text = json.dumps(scenes.usual_scene() | {part: data}).encode()
    held(Case(f"{part} = {data!r}", lambda folder: load_scene(folder / "scene.json"), {"scene.json": text}))
