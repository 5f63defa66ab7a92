"""Run folders in which files are damaged, changed or missing: read back by the store, shown by the report."""

from __future__ import annotations

import functools
import json
import tempfile
from pathlib import Path

from pydantic import BaseModel

from physagent_jax.report.html import write_report
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.store import RunStore
from tests.fuzz.contract import Breach, Case, Fault
from tests.fuzz.drawing import Draw, altered, damaged, encoded, of_schema
from tests.report.fake_run import build_run

RUN = "run"


def make(draw: Draw) -> Case:
    """One folder with one to three files that are not as the loop left them."""
    files, done = dict(_read_good()), []
    for _ in range(draw.one([1, 1, 2, 3])):
        name = draw.one(sorted(files))
        if not name.endswith(".json") or draw.chance(0.2):
            what, content = damaged(draw, files[name], [files[other] for other in sorted(files)])
            files[name] = content
        elif draw.chance(0.1):
            what = "missing"
            del files[name]
        elif draw.chance(0.25):
            schema = _make_schemas()[name.rsplit("/", 1)[-1]]
            what, files[name] = "of the schema", encoded(of_schema(draw, schema))
        else:
            try:
                what, files[name] = altered(draw, json.loads(files[name]))
            except (ValueError, RecursionError):
                what = "damaged before"
        done.append(f"{name}: {what}")
    files = {f"{RUN}/{name}": content for name, content in files.items()}
    if draw.chance(0.3):
        return Case(f"resumed: {'; '.join(done)}", _open, files)
    return Case(f"shown: {'; '.join(done)}", _show, files, own=(f"{RUN}/report.html",))


def _show(folder: Path):
    page = write_report(folder / RUN)
    text = Path(page).read_text(encoding="utf-8")
    if not text.rstrip().endswith("</html>"):
        raise Breach(Fault.LITTER, "the page has no end")


def _open(folder: Path):
    manifest = Manifest.model_validate_json(_read_good()["manifest.json"])
    with RunStore.open(folder / RUN, manifest) as store:
        models = {
            name: _list_models()[name.rsplit("/", 1)[-1]] for name in _read_good() if name.endswith(".json")
        }
        read = [store.read(name, model) for name, model in models.items()]
        return store.manifest, read


@functools.cache
def _read_good() -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as folder:
        run = build_run(Path(folder, RUN), size=32)
        found = {str(p.relative_to(run)): p.read_bytes() for p in sorted(run.rglob("*")) if p.is_file()}
    return {name: content for name, content in found.items() if "/1/" not in name}


@functools.cache
def _make_schemas() -> dict[str, dict]:
    return {name: model.model_json_schema() for name, model in _list_models().items()}


def _list_models() -> dict[str, type[BaseModel]]:
    from physagent_jax.agents.schema import Rewrite, SemanticReply
    from physagent_jax.agents.trace import Trace
    from physagent_jax.forces.schema import ForceField
    from physagent_jax.motion.schema import Judgement
    from physagent_jax.perception.schema import MotionReport
    from physagent_jax.scene.config import SceneConfig
    from physagent_jax.simulation.record import SimulationRecord

    models = {
        "manifest": Manifest, "semantic": SemanticReply, "scene": SceneConfig, "force_field": ForceField,
        "motion_report": MotionReport, "judgement": Judgement, "rewrite": Rewrite, "simulation": SimulationRecord,
        "semantic_trace": Trace, "planner_trace": Trace, "executor_trace": Trace,
    }  # fmt: skip
    return {f"{name}.json": model for name, model in models.items()}
