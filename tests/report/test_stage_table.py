"""The page's table of a sentence's stages."""

import json

import pytest

from physagent_jax.motion.schema import Judgement, Stage
from physagent_jax.report.html import write_report
from tests.report.fake_run import build_run
from tests.report.test_html import Page


def stage(number, verdict, **told) -> Stage:
    window = (10.0 * number, 10.0 * number + 9)
    return Stage(expectations=(number,), window=window, verdict=verdict, **told)


STAGES = (
    stage(0, "met", words="push it left", asked="how far? 0.25 to 1.3", measured="0.5 lengths"),
    stage(1, "not met", words="<spin> it", asked="how far does it turn?", measured="4 degrees", misfit=0.6),
    stage(2, "not seen", words="let it fall"),
)


@pytest.mark.parametrize("count", [1, 3])
def test_stages_are_a_table_where_there_are_several(tmp_path, count):
    folder = build_run(tmp_path)
    path = folder / "iterations" / "0" / "judgement.json"
    judgement = Judgement.model_validate_json(path.read_text()).model_copy(update={"stages": STAGES[:count]})
    path.write_text(judgement.model_dump_json())
    text = Page(write_report(folder).read_text()).text
    assert ("The sentence stage by stage" in text) == (count > 1)
    if count > 1:
        assert "1 push it left 0–9 how far? 0.25 to 1.3 0.5 lengths ✓ met" in text
        assert "2 <spin> it 10–19 how far does it turn? 4 degrees ✗ not met" in text
        assert "3 let it fall 20–29" in text and "? not seen" in text


def test_the_reason_for_the_end_of_the_rounds_is_at_a_glance(tmp_path):
    folder = build_run(tmp_path)
    path = folder / "manifest.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "stopped": "no improvement"}))
    assert "the last rounds brought no improvement" in Page(write_report(folder).read_text()).text
