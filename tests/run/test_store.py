"""Run folders: only files of the run's own are touched, and what it replaces stands until it is complete itself."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import link_or_copy, remove_leftovers, replace_file, write_new, write_text
from physagent_jax.run.manifest import Manifest, Stages
from physagent_jax.run.store import RunStore

FILES = ("semantic.json", "iterations/0/judgement.json", "iterations/0/video.mp4", "video.mp4")


class Killed(BaseException):
    """The process ends here."""


def manifest(name):
    return Manifest(
        command="test", prompt=name, versions={}, platform="test", seed=0, inputs={"settings": name}
    )


def make(path, name, **options):
    """A whole run whose files hold its name."""
    with RunStore.open(path, manifest(name), **options) as store:
        if store.manifest.complete:
            return store
        store.begin()
        for file in FILES:
            write_text(store.claimed(file), name)
        store.finish(stages=Stages())
        return store


def contents(path):
    """All files but the manifest, and whose run the manifest says it is."""
    files = {p.relative_to(path).as_posix(): p.read_bytes() for p in path.rglob("*") if p.is_file()}
    if "manifest.json" in files:
        read = Manifest.model_validate_json(files.pop("manifest.json"))
        files["whose"] = read.prompt.encode()
    return files


def of(name, files=FILES):
    return {file: name.encode() for file in (*files, "whose")}


def test_a_run_is_listed_before_it_is_written_and_found_again(tmp_path):
    store = make(tmp_path / "run", "one")
    assert set(store.manifest.files) == {"manifest.json", "report.html", *FILES}
    assert contents(tmp_path / "run") == of("one")
    assert make(tmp_path / "run", "one").manifest == store.manifest


def test_a_file_under_two_names_is_replaced_under_one(tmp_path):
    """As at the top of a run folder: whoever replaces one of the names leaves the other."""
    write_text(tmp_path / "round.npz", "one")
    for _ in range(2):  # a run that was stopped at its end puts the best round on top again
        with replace_file(tmp_path / "top.npz") as temporary:
            link_or_copy(tmp_path / "round.npz", temporary)
        assert os.path.samefile(tmp_path / "round.npz", tmp_path / "top.npz")
        assert len(list(tmp_path.iterdir())) == 2
    write_text(tmp_path / "round.npz", "two")
    assert (tmp_path / "top.npz").read_text() == "one"


def test_runs_with_linked_files_are_replaced_and_restored(tmp_path):
    path = tmp_path / "run"

    def make_linked(name, *, stopped=False):
        with RunStore.open(path, manifest(name), overwrite=True) as store:
            store.begin()
            write_text(store.claimed("iterations/0/motion.npz"), name)
            with replace_file(store.claimed("motion.npz")) as temporary:
                link_or_copy(path / "iterations/0/motion.npz", temporary)
            if not stopped:
                store.finish(stages=Stages())

    names = ("iterations/0/motion.npz", "motion.npz")
    make_linked("one")
    make_linked("two", stopped=True)
    aside = path / ".previous"
    assert [(aside / name).read_text() for name in names] == ["one"] * 2
    with RunStore.open(path, manifest("three"), overwrite=True):  # the stopped one gives way
        assert [(path / name).read_text() for name in names] == ["one"] * 2
    make_linked("three")
    assert contents(path) == of("three", names) and os.path.samefile(*(path / name for name in names))


def test_another_run_needs_overwrite_and_then_replaces_only_what_the_first_wrote(tmp_path):
    path = tmp_path / "run"
    make(path, "one")
    (path / "notes.txt").write_text("precious")
    (path / "iterations" / "0" / "mine.png").write_text("precious")
    with pytest.raises(UserError, match="holds another run.*--overwrite"):
        make(path, "two")
    make(path, "two", overwrite=True)
    kept = {"notes.txt": b"precious", "iterations/0/mine.png": b"precious"}
    assert contents(path) == of("two") | kept


def test_a_folder_that_is_not_a_run_is_never_touched(tmp_path):
    for index, content in enumerate(('{"name": "a web app", "icons": []}', "[]", "", "\x00\xff")):
        path = tmp_path / str(index)
        path.mkdir()
        (path / "manifest.json").write_text(content)
        (path / "index.html").write_text("precious")
        for overwrite in (False, True):
            with pytest.raises(UserError, match="not a run folder"):
                make(path, "one", overwrite=overwrite)
        assert (path / "manifest.json").read_text() == content
        assert (path / "index.html").read_text() == "precious"


def test_a_manifest_cannot_name_files_outside_its_folder(tmp_path):
    """A folder from elsewhere could make `--overwrite` remove anything."""
    (tmp_path / "thesis.tex").write_text("precious")
    make(tmp_path / "run", "one")
    place = tmp_path / "run" / "manifest.json"
    for name in ("../thesis.tex", str(tmp_path / "thesis.tex"), "iterations/../../thesis.tex"):
        place.write_text(place.read_text().replace('"video.mp4"', f'"{name}"'))
        with pytest.raises(UserError, match="not a run folder"):
            make(tmp_path / "run", "two", overwrite=True)
        place.write_text(place.read_text().replace(f'"{name}"', '"video.mp4"'))
    assert (tmp_path / "thesis.tex").read_text() == "precious"


def test_a_file_that_is_not_the_runs_is_not_written_over(tmp_path):
    with RunStore.open(tmp_path / "run", manifest("one")) as store:
        store.begin()
        (tmp_path / "run" / "video.mp4").write_text("precious")
        with pytest.raises(UserError, match=r"video\.mp4 is not this run's"):
            store.claim("video.mp4")
    assert (tmp_path / "run" / "video.mp4").read_text() == "precious"


def test_what_a_run_needs_is_not_replaced_by_it(tmp_path):
    path = tmp_path / "run"
    make(path, "one")
    before = contents(path)
    with pytest.raises(UserError, match="needed for the new one"):
        make(path, "two", overwrite=True, needed=[path / "semantic.json"])
    assert contents(path) == before
    (path / "object.ply").write_text("the object")
    make(path, "two", overwrite=True, needed=[path / "object.ply"])
    assert contents(path) == of("two") | {"object.ply": b"the object"}


def test_a_run_that_comes_to_nothing_gives_back_what_it_was_to_replace(tmp_path):
    path = tmp_path / "run"
    make(path, "one")
    with RunStore.open(path, manifest("two"), overwrite=True) as store:
        store.begin()
        write_text(store.claimed("semantic.json"), "two")
        store.discard_if_barren()
    assert contents(path) == of("one")


def test_nothing_is_left_where_nothing_was_begun(tmp_path):
    with RunStore.open(tmp_path / "a" / "b" / "run", manifest("one")):
        pass
    assert not (tmp_path / "a").exists()


def test_an_unfinished_run_goes_on_with_overwrite_and_gives_way_to_what_it_was_to_replace(tmp_path):
    path = tmp_path / "run"
    make(path, "one")
    with RunStore.open(path, manifest("two"), overwrite=True) as store:
        store.begin()
        write_text(store.claimed("semantic.json"), "two")
    with RunStore.open(path, manifest("two"), overwrite=True) as store:
        assert "semantic.json" in store.manifest.files and not store.manifest.complete
    with pytest.raises(UserError, match="'two'.*before it had replaced the run of 'one'.*stands again"):
        RunStore.open(path, manifest("one"))
    assert make(path, "one", overwrite=True).manifest.complete  # it stands again: nothing is made anew
    assert contents(path) == of("one")


@pytest.mark.parametrize("kind", ["folder", "dangling", "file"])
def test_links(kind, tmp_path):
    """A link to a folder is that folder; other links and files are refused."""
    link, target = tmp_path / "run", tmp_path / "target"
    if kind == "folder":
        target.mkdir()
    elif kind == "file":
        target.write_text("precious")
    link.symlink_to(target)
    if kind == "folder":
        make(link, "one")
        make(link, "two", overwrite=True)
        assert contents(target) == of("two") and link.is_symlink()
    else:
        with pytest.raises(UserError, match="cannot write to|cannot write"):
            make(link, "one")


def test_leftovers_of_a_killed_process_go_and_other_hidden_files_stay(tmp_path):
    path = tmp_path / "run"
    make(path, "one")
    (path / ".video.0123abcd.mp4").write_text("half")
    (path / ".video.backup.mp4").write_text("precious")
    make(path, "one")
    assert not (path / ".video.0123abcd.mp4").exists() and (path / ".video.backup.mp4").exists()
    remove_leftovers(tmp_path / "absent" / "x.json")


def test_a_process_killed_before_it_had_a_manifest_has_begun_nothing(tmp_path):
    path = tmp_path / "run"
    path.mkdir()
    (path / ".manifest.0123abcd.json").write_text("{")
    make(path, "one")
    assert contents(path) == of("one")


def test_the_second_process_in_a_folder_is_told_so(tmp_path):
    path = tmp_path / "run"
    program = (
        "import sys; from tests.run.test_store import RunStore, manifest\n"
        "store = RunStore.open(sys.argv[1], manifest('one')); store.begin(); print('ready', flush=True); input()"
    )
    command = [sys.executable, "-c", program, str(path)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2]
    ) as other:
        assert other.stdout is not None and other.stdin is not None
        assert other.stdout.readline() == "ready\n"
        for overwrite in (False, True):
            with pytest.raises(UserError, match="another process is writing"):
                RunStore.open(path, manifest("one"), overwrite=overwrite)
        other.kill()  # the lock goes with the process
        other.wait()
        RunStore.open(path, manifest("one")).close()


class Countdown:
    """Ends the process at the n-th change to the disk, before or after it happens."""

    def __init__(self, monkeypatch, count, *, after):
        self.left, self.after = count, after
        for name in ("replace", "unlink", "rmdir", "mkdir"):
            monkeypatch.setattr(os, name, self._count_calls(getattr(os, name)))

    def _count_calls(self, change):
        def counted(*arguments, **options):
            self.left -= 1
            if self.left == 0 and not self.after:
                raise Killed
            result = change(*arguments, **options)
            if self.left == 0:
                raise Killed
            return result

        return counted


@pytest.mark.parametrize("after", [False, True])
def test_a_process_may_be_killed_at_any_change_to_the_disk(after, tmp_path, monkeypatch):
    """Then the same command makes the new run, and the old command finds the old one, untouched or whole again."""
    for count in range(1, 200):
        path = tmp_path / str(count)
        make(path, "one")
        (path / "notes.txt").write_text("precious")
        with monkeypatch.context() as patch:
            countdown = Countdown(patch, count, after=after)
            try:
                make(path, "two", overwrite=True)
            except Killed:
                pass
        copy = shutil.copytree(path, tmp_path / f"{count}-copy")

        make(path, "two", overwrite=True)
        assert contents(path) == of("two") | {"notes.txt": b"precious"}, count

        RunStore.open(copy, manifest("one"), overwrite=True).close()
        stands = contents(copy)["whose"].decode()
        assert contents(copy) == of(stands) | {"notes.txt": b"precious"}, count
        assert Manifest.model_validate_json((copy / "manifest.json").read_bytes()).complete
        if countdown.left > 0:
            assert stands == "two" and count > 20
            return
    raise AssertionError("more changes to the disk than expected")


def test_new_files_are_all_written_or_none(tmp_path):
    ply, card = tmp_path / "a.ply", tmp_path / "a.card.json"
    card.write_text("precious")
    with pytest.raises(UserError, match=r"a\.card\.json exists and holds something else"):
        write_new({ply: b"ply", card: b"card"}, overwrite=False)
    assert not ply.exists() and card.read_text() == "precious"
    write_new({ply: b"ply", card: b"precious"}, overwrite=False)  # the same again is fine
    write_new({ply: b"ply", card: b"card"}, overwrite=True)
    assert (ply.read_bytes(), card.read_bytes()) == (b"ply", b"card")


def test_devices_pipes_and_folders_are_not_replaced(tmp_path):
    """A rename by root would make a plain file of /dev/null, for all programs of the machine."""
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to("nowhere")
    for path in (tmp_path, pipe, link):
        before = path.lstat()
        for write in (partial(write_new, {path: b""}, overwrite=True), partial(write_text, path, "")):
            with pytest.raises(UserError, match="a folder, a device or a pipe|a link"):
                write()
        assert path.lstat().st_ino == before.st_ino


def test_a_path_of_thousands_of_folders_is_refused(tmp_path):
    path = tmp_path.joinpath(*["a"] * 1500)
    for write in (lambda: write_text(path / "x.json", ""), lambda: make(path, "one")):
        with pytest.raises(UserError, match="more than 64 folders"):
            write()
    assert not list(tmp_path.iterdir())
