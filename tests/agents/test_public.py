"""Public sentences keep their motions: those of README, of the first results and of the benchmark tasks."""

import json
from pathlib import Path

import pytest

from benchmarks.language.score import make_scene
from physagent_jax.agents.grammar.semantic import read_sentence
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from tests.agents.sentences import load_table

TABLE = load_table("public.yaml")
ROWS = [(name, text, told) for name, rows in TABLE.items() for text, told in rows.items()]
TASKS = Path(__file__).parents[2] / "benchmarks" / "tasks"
AXES = (("right", "left"), ("away", "toward"), ("up", "down"))
LEAST = 0.2  # component of a unit vector that a name stands for


def name_ways(direction: tuple[float, ...]) -> str:
    return "+".join(
        names[component < 0] for component, names in zip(direction, AXES) if abs(component) > LEAST
    )


def tell(motion: ExpectedMotion) -> str:
    """A motion as "hit left+up x2 on up stays by 0.5 lengths"; a time alone is no amount."""
    words = ["hit" if motion.sudden and motion.kind is MotionKind.MOVE else motion.kind.value]
    words += [name_ways(motion.direction)] if motion.direction else []
    words += [f"x{motion.repeats}"] if motion.repeats > 1 else []
    words += ["on", name_ways(motion.part)] if motion.part else []
    words += ["stays"] if motion.stays else []
    if motion.amount is not None and motion.amount.unit != "seconds":
        words.append(f"by {motion.amount.value:.3g} {motion.amount.unit}")
    return " ".join(words)


@pytest.mark.parametrize(("name", "text", "told"), ROWS, ids=[row[1][:60] for row in ROWS])
def test_motions_of_public_sentences(name, text, told):
    """Kinds, ways, parts, counts and amounts, in their order."""
    assert "; ".join(map(tell, read_sentence(text, make_scene(name)).expectations)) == told


def test_all_tasks_are_held():
    """Each sentence of a benchmark task stands in the table."""
    files = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(TASKS.glob("*.json"))]
    tasks = [task["sentence"] for file in files for task in _list_tasks(file)]
    assert len(tasks) >= 60
    assert set(tasks) <= {text for _, text, _ in ROWS}


def _list_tasks(value) -> list[dict]:
    """The objects with a sentence inside a JSON value."""
    if isinstance(value, list):
        return [task for each in value for task in _list_tasks(each)]
    if not isinstance(value, dict):
        return []
    return [value] if "sentence" in value else [task for each in value.values() for task in _list_tasks(each)]
