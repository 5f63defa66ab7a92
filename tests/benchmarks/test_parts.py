"""The benchmark of parts: its table of answers, and how its rows are counted."""

import numpy as np
import trimesh

from benchmarks.parts.answers import Answers, read_things
from benchmarks.parts.markdown import write_tables
from physagent_jax.scene.mesh_files import read_named_parts


def test_both_halves_have_objects_and_every_file_is_pinned():
    things = read_things()
    assert len(things) >= 30 and sum(len(each.parts) for each in things) >= 80
    assert {each.half for each in things} == {"developed with", "held back"}
    assert len({each.file.sha256 for each in things}) == len(things) == len({each.name for each in things})
    assert all(len(each.file.sha256) == 64 and each.file.credit for each in things)


def test_answers_are_the_surfaces_of_a_name_and_the_mesh_is_written_without_it(tmp_path):
    scene = trimesh.Scene()
    for name, x in (("lid", 0.0), ("pot", 3.0)):
        box = trimesh.creation.box()
        box.apply_translation((x, 0, 0))
        scene.add_geometry(box, node_name=name, geom_name=name)
    path, bare = tmp_path / "pot.glb", tmp_path / "bare.glb"
    path.write_bytes(scene.export(file_type="glb"))
    answers = Answers(path)
    owners = answers.list_owners(np.array([(0.1, 0, 0), (2.9, 0, 0)]))
    assert [answers.list_fitting((name,)) for name in ("l*", "pot")] == [[owners[0]], [owners[1]]]
    answers.write(bare)
    assert read_named_parts(path) and not read_named_parts(bare)


def test_rows_are_counted_by_half_and_form():
    rows = [
        dict(job="pot", word=word, form=form, outcome=outcome, overlap=0.5, unsure=unsure)
        for form in ("mesh", "capture")
        for word, outcome, unsure in (
            ("lid", "right", True),
            ("knob", "asked for", False),
            ("spout", "wrong", True),
        )
    ]
    section = dict(runs=[], complete=True, rows=rows)
    tables = write_tables({"held back": section})
    assert "| held back | mesh | 3 | 33 % (1) | 33 % (1) | 33 % (1) | 1 of 2 |" in tables["totals"]
    assert "| pot | held back | lid | right (0.50) | right (0.50) |" in tables["each"]
