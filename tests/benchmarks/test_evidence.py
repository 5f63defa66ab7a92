"""Pages, their summaries and the code that these were measured on."""

import dataclasses
import hashlib
import json
import re
import subprocess
from pathlib import Path

import pytest

from baselines.evaluation import GRADIENT_COST
from baselines.fits import CAP
from benchmarks.evidence import summaries
from benchmarks.evidence.__main__ import STATE, describe_state, find_differing, main
from benchmarks.evidence.catalogue import DOCS, PAGES, RESULTS, ROOT
from benchmarks.evidence.summaries import read_summary, summarise
from benchmarks.harness import Page, make_lines, read_lines, sources
from benchmarks.harness.pages import empty_place, fill_pages, fill_places
from benchmarks.harness.sources import hash_sources, is_checkout, is_known, strip_python
from benchmarks.inverse.fitting import ADAM_STEPS, LM_STEPS
from benchmarks.language import totals
from benchmarks.language.notation import read_split
from benchmarks.peers import drop, flight
from benchmarks.skipping.measure import CHANCE, LEAST
from benchmarks.stability.dt_crit import REQUIRED
from benchmarks.throughput.markdown import AIMED_AT
from physagent_jax.core.errors import UserError

_PICTURES = (".png", ".jpg", ".gif")
_LARGEST, _ALL_RESULTS = 220_000, 1_500_000  # bytes: the first results have every sentence that was ever run
_REVISION = re.compile(
    r"\b(?=[0-9a-f]*[a-f])[0-9a-f]{12}\b(-dirty)?|[Rr]evision `?([0-9a-f]{7,40}(?:-dirty)?)\b"
)

needs_history = pytest.mark.skipif(not is_checkout(), reason="needs a git checkout with its whole history")


def list_tracked():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


@needs_history
def test_tracked_files_are_small():
    """Pictures and the bundled robot apart; all results together too."""
    sizes = {path.relative_to(ROOT): path.stat().st_size for path in list_tracked()}
    large = {str(path) for path, size in sizes.items() if size > _LARGEST and path.suffix not in _PICTURES}
    assert large <= {"examples/assets/robot.ply"}
    assert (
        sum(size for path, size in sizes.items() if path.parent == Path("benchmarks/results")) <= _ALL_RESULTS
    )


@needs_history
def test_every_revision_that_is_cited_exists_and_none_is_dirty():
    files = [*DOCS.glob("*.md"), *RESULTS.glob("*.json"), ROOT / "README.md", ROOT / "CHANGELOG.md"]
    cited = {
        (path.name, found[0].split()[-1].strip("`"))
        for path in files
        for found in _REVISION.finditer(path.read_text())
    }
    assert len({revision for _, revision in cited}) > 20  # the expression finds them
    known = {revision: is_known(revision) for _, revision in cited}
    assert not [(name, revision) for name, revision in cited if not known[revision]]


@pytest.mark.parametrize("text", ["2a8faa1c53b0-dirty", "revision `c7af4e2`", "Revision c7af4e2-dirty of"])
def test_revisions_are_recognised(text):
    assert _REVISION.search(text) and not _REVISION.search(
        "123456789012 and a digest 2a8faa1c53b02a8faa1c53b0"
    )


@needs_history
def test_raw_rows_are_restored_from_history_and_never_over_others(tmp_path, monkeypatch, capsys):
    """They give the same summary again."""
    monkeypatch.setattr("benchmarks.evidence.__main__.ROOT", tmp_path)
    monkeypatch.setattr("benchmarks.evidence.__main__.list_stale", lambda pages: "")
    assert main(["distillation", "--restore"]) == 0
    kept, raw = (
        read_summary(RESULTS / "distillation.json"),
        tmp_path / "benchmarks" / "raw" / "distillation.json",
    )
    assert json.loads(raw.read_text())["cosines"]["rows"]
    restored = summarise(PAGES["distillation"], raw)["parts"]
    assert restored == {part: kept["parts"][part] for part in restored}
    assert (
        main(["distillation", "--restore"]) == 2 and "there are raw rows already" in capsys.readouterr().err
    )
    with pytest.raises(UserError, match="has no raw rows"):
        summaries.restore(PAGE, {"raw": {"part": {"sha256": "s"}}})


@needs_history
def test_rows_of_history_are_read_by_the_names_of_today_and_stay_rows_of_history(tmp_path, monkeypatch):
    """A page renames what it restores; a summary of the restored rows says where they are from, of others not."""
    run = {"quick": False, "seconds": 2.0, "git_revision": None}
    row = {"run": 0, "job": "old", "value": 1, "long": "x"}
    rows = {"part": {"runs": [run], "complete": True, "rows": [row]}}
    content = json.dumps(rows).encode()
    monkeypatch.setattr(summaries, "read_object", lambda name: content)
    file = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest(), "history": "r:f"}

    def rename(result):
        named = [row | {"job": "new"} for row in result["part"]["rows"]]
        return {"part": result["part"] | {"rows": named}}

    page = dataclasses.replace(PAGE, rename=rename)
    restored = summaries.restore(page, {"raw": {"part": file}})
    assert restored["part"]["rows"][0]["job"] == "new"
    raw = tmp_path / "raw.json"
    raw.write_text(json.dumps(restored))
    earlier = {"raw": {"part": file}, "parts": {}}
    assert summarise(page, raw, earlier)["raw"] == {"part": file}
    restored["part"]["rows"][0]["value"] = 2
    raw.write_text(json.dumps(restored))
    assert "history" not in summarise(page, raw, earlier)["raw"]["part"]


@needs_history
def test_raw_rows_that_history_has_are_those_that_were_summarised():
    for name in PAGES:
        for file in read_summary(RESULTS / f"{name}.json")["raw"].values():
            if "history" in file and "sha256" in file:
                shown = subprocess.run(
                    ["git", "show", file["history"]], cwd=ROOT, capture_output=True, check=True
                )
                assert hashlib.sha256(shown.stdout).hexdigest() == file["sha256"]
                assert len(shown.stdout) == file["bytes"]


def test_pages_are_what_their_summaries_give():
    """The line apart that says whether code has changed since: any commit may change it."""
    assert find_differing(list(PAGES.values())) == []


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("inverse", f"at most {LM_STEPS} trial steps"),
        ("inverse", f"at most {ADAM_STEPS} gradients"),
        ("inverse", f"a gradient is {GRADIENT_COST:g}"),
        ("head-to-head", f"a value with its gradient is charged {GRADIENT_COST:g}"),
        ("head-to-head", f"cut at {CAP:g}."),
        *(
            ("language", f"{split}: at least {least:.0%} right, at most {most:.0%} silently wrong")
            for split, (least, most) in totals.REQUIRED.items()
        ),
        (
            "skipping",
            f"as measurable above {LEAST * 100:g} %, where a sign test gives chance less than {CHANCE * 100:g} %",
        ),
        ("stability", f"Required: at least {REQUIRED:g}."),
        ("throughput", f"There are {drop.CELLS} cells along the domain"),
        ("throughput", f"The substep is {drop.DT:g} s"),
        ("throughput", f"frames of {drop.FRAME_DT:g} s"),
        ("throughput", f"Aims are at {AIMED_AT:,} particles"),
        ("throughput", f"in free flight for {flight.FRAMES * flight.FRAME_DT:g} s"),
        ("throughput", f"It has {flight.CELLS} cells along the domain"),
        ("throughput", f"neo-Hookean with {flight.YOUNGS_MODULUS:,.0f} Pa"),
        ("throughput", f"from the reference's, over {flight.FRAMES} frames"),
    ],
)
def test_pages_state_the_numbers_of_the_code(page, words):
    assert words in " ".join((DOCS / f"{page}.md").read_text().split())


def test_the_page_of_language_says_how_many_sentences_there_are():
    """Counted here: whoever collects the tests would read them all."""
    sentences = sum(len(read_split(split)) for split in totals.REQUIRED)
    test_pages_state_the_numbers_of_the_code("language", f"of {sentences:,} sentences")


@needs_history
def test_stale_pages_are_listed_with_the_command_that_measures_them_again(capsys, monkeypatch):
    monkeypatch.setattr(
        "benchmarks.evidence.__main__.find_changed", lambda page, summary: ["physagent_jax/mpm"]
    )
    assert main(["startup", "inverse", "--check"]) == 0
    told = capsys.readouterr().out
    assert "2 of 2 pages" in told
    assert "| startup | physagent_jax/mpm | `python -m benchmarks.startup` |" in told
    assert "| inverse | revision not recorded | `python -m benchmarks.inverse --images docs/images` |" in told
    assert main(["nonsense"]) == 2 and "There are: accuracy" in capsys.readouterr().err


def test_a_page_says_by_itself_that_code_has_changed(monkeypatch):
    page = PAGES["startup"]
    code = {"revision": "abc", "date": "2026-01-02", "hashes": {"physagent_jax": "then"}}
    for now, words in (
        ("now", "code has changed since: `physagent_jax`."),
        ("then", "has not changed since."),
    ):
        monkeypatch.setattr(
            "benchmarks.evidence.__main__.hash_sources", lambda names, now=now: {names[0]: now}
        )
        assert words in describe_state(page, {"code": code})
    assert "is not recorded" in describe_state(page, {"code": None})


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """A repository with a module and a text in a folder, and what commits all and returns the revision."""
    monkeypatch.setattr(sources, "ROOT", tmp_path)

    def run(*words):
        who = ["-c", "user.name=n", "-c", "user.email=e"]
        return subprocess.run(
            ["git", *who, *words], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout

    def commit():
        run("add", "-A")
        run("commit", "-q", "-m", "x")
        return run("rev-parse", "--short=12", "HEAD").strip()

    run("init", "-q")
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "a.py").write_text('"""Doc."""\n\n\ndef f():\n    """Doc."""\n    return 1  # one\n')
    (tmp_path / "code" / "tasks.txt").write_text("a\n")
    return tmp_path / "code", commit


def test_hashes_are_of_code_and_not_of_words_about_it(repository):
    """The working tree's are those of the revision that it was checked out from."""
    folder, commit = repository
    first = commit()
    then = hash_sources(("code",), first)
    assert hash_sources(("code",)) == then and is_known(first) and not is_known("0" * 12)
    (folder / "a.py").write_text('"""Other words."""\n\n# A comment.\ndef f():\n    return 1  # one\n')
    assert hash_sources(("code",)) == then
    (folder / "a.py").write_text("def f():\n    return 2  # one\n")
    assert hash_sources(("code",)) != then
    second = commit()
    assert (
        hash_sources(("code",), second) == hash_sources(("code",)) != then == hash_sources(("code",), first)
    )
    assert sources.find_newest([second]) == second and sources.find_newest([]) is None
    (folder / "tasks.txt").write_text("b\n")
    assert hash_sources(("code",)) != hash_sources(("code",), second)


def test_strings_that_are_no_docstrings_stay():
    code = 'x = """a\n\n# b\n"""\n\n"""Of x."""\n\n# c\ny = f"""{x}\n\n# d"""\n'
    assert strip_python(code) == 'x = """a\n\n# b\n"""\ny = f"""{x}\n\n# d"""'
    assert strip_python("no python: (\n\n# text") == "no python: (\n\n# text"


def write_raw(path, **changes):
    run = {"quick": False, "seconds": 2.0, "git_revision": None} | changes
    rows = [{"run": 1, "job": "j", "value": 1, "long": "x" * 50}]
    section = {"runs": [run | {"git_revision": "0" * 12}, run], "complete": True, "rows": rows}
    path.write_text(json.dumps({"part": section}))
    return path


def drop_long(result):
    for section in result.values():
        for row in section["rows"]:
            del row["long"]
    return result


PAGE = Page("made-up", "python -m made.up", lambda result: {}, condense=drop_long)


def test_a_summary_has_the_hash_of_its_raw_rows_and_no_run_without_rows(tmp_path):
    raw = write_raw(tmp_path / "raw.json")
    summary = summarise(PAGE, raw)
    (entry,) = summary["raw"].values()
    assert entry == {"bytes": raw.stat().st_size, "sha256": hashlib.sha256(raw.read_bytes()).hexdigest()}
    section = summary["parts"]["part"]
    assert len(section["runs"]) == 1 and section["rows"] == [{"run": 0, "job": "j", "value": 1}]
    assert summary["code"] is None
    assert json.loads(summaries.format_summary(summary)) == summary


def test_parts_that_were_not_measured_again_stay(tmp_path):
    earlier = summarise(PAGE, write_raw(tmp_path / "raw.json"))
    earlier["raw"]["other"], earlier["parts"]["other"] = {"sha256": "s"}, earlier["parts"]["part"]
    again = summarise(PAGE, write_raw(tmp_path / "raw.json", seconds=3.0), earlier)
    assert again["raw"]["other"] == {"sha256": "s"} and again["parts"]["other"]["runs"][0]["seconds"] == 2.0
    assert again["parts"]["part"]["runs"][0]["seconds"] == 3.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"quick": True}, "quick rows"), ({"git_revision": "0123456789ab-dirty"}, "cannot be looked up")],
)
def test_rows_that_are_not_to_be_quoted_are_refused(tmp_path, changes, words):
    raw = write_raw(tmp_path / "raw.json", **changes)
    with pytest.raises(UserError, match=words):
        summarise(PAGE, raw)
    with pytest.raises(UserError, match="no raw rows"):
        summarise(PAGE, tmp_path / "absent.json")


def test_rows_of_a_revision_that_was_not_kept_name_none(tmp_path):
    raw = write_raw(tmp_path / "raw.json", git_revision="0123456789ab-dirty")
    summary = summarise(PAGE, raw, allow_unkept=True)
    assert summary["parts"]["part"]["runs"][0]["git_revision"] is None


def test_a_part_that_was_stopped_does_not_replace_a_whole_one(tmp_path):
    raw = write_raw(tmp_path / "raw.json")
    whole, content = summarise(PAGE, raw), json.loads(raw.read_text())
    content["part"]["complete"] = False
    raw.write_text(json.dumps(content))
    with pytest.raises(UserError, match="is not whole"):
        summarise(PAGE, raw, whole)


def test_what_stands_between_marks_is_replaced_and_nothing_else():
    page = (
        "# T\n<!-- table: a -->\nold\n\nolder\n<!-- end -->\nwords\n<!-- table: b c -->\nold\n<!-- end -->\n"
    )
    filled = fill_places(page, {"a": "\n| x |\n"})
    assert filled == "# T\n<!-- table: a -->\n| x |\n<!-- end -->\nwords\n<!-- table: b c -->\n<!-- end -->\n"
    assert fill_places(filled, {"a": "| x |"}) == filled
    assert empty_place(filled, "a") == filled.replace("| x |\n", "")
    with pytest.raises(UserError, match="no place for a table.*<!-- table: d -->"):
        fill_places(page, {"a": "", "d": "| y |"})


def test_a_page_that_is_not_there_is_made_of_places_alone(tmp_path):
    tables, page = {"a": "| x |", "b": ""}, tmp_path / "page.md"
    made = fill_pages([page, tmp_path / "details.md"], tables)
    page.write_text(made[page])
    assert "| x |" in made[page] and fill_pages([page], tables) == made


def test_tables_find_their_places_on_two_pages(tmp_path):
    page, details = tmp_path / "page.md", tmp_path / "details.md"
    page.write_text("<!-- table: a -->\n<!-- end -->\n<!-- table: state -->\n<!-- end -->\n")
    details.write_text("<!-- table: b -->\n<!-- end -->\n<!-- table: state -->\n<!-- end -->\n")
    made = fill_pages([page, details], {"a": "| x |", "b": "| y |", "state": "new"})
    assert "| x |" in made[page] and "| y |" in made[details] and all("new" in each for each in made.values())
    with pytest.raises(UserError, match="no place for a table.*<!-- table: c -->"):
        fill_pages([page, details], {"c": "| z |"})


def test_tables_are_kept_as_lines():
    tables = {"a": "\n| x |\n| y |\n", "b": "words"}
    lines = make_lines(tables)
    assert lines[1] == {"table": "a", "line": "| y |"} and len(lines) == 3
    assert read_lines({"part": {"rows": lines}}) == {"a": "| x |\n| y |", "b": "words"}


def test_every_page_has_a_place_for_its_state():
    assert all(f"<!-- table: {STATE} -->" in (DOCS / f"{name}.md").read_text() for name in PAGES)
