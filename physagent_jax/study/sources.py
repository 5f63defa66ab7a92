"""Clips of methods: finished runs, or videos with a sentence beside them, matched by their names."""

from __future__ import annotations

import dataclasses
import io
import os
from pathlib import Path

import av
from av.error import FFmpegError

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import read_bytes, read_json, shorten
from physagent_jax.motion.schema import Verdict
from physagent_jax.run.finished import open_run
from physagent_jax.run.store import PLAIN_VIDEO, VIDEO
from physagent_jax.study.schema import Judged

_SENTENCE_BYTES = 4096


@dataclasses.dataclass(frozen=True)
class Source:
    """A method's clip of an item.

    Attributes:
        method: Name of the method.
        sentence: What was asked for.
        folder: The run folder, or the folder of the video.
        videos: Kinds of video that there are, with their files: `VIDEO` has a stage, `PLAIN_VIDEO` has none.
        judged: The opinion of this code's judge.
    """

    method: str
    sentence: str
    folder: Path
    videos: dict[str, Path]
    judged: Judged | None = None


def read_method(given: str) -> tuple[str, dict[str, Source]]:
    """A method's name and its clips by the name of their item: the path below the method's folder.

    Args:
        given: Its folder, or NAME=FOLDER.

    Raises:
        UserError: There is no such folder, or it holds no clip.
    """
    name, folder = "", Path(given)
    if "=" in given and not folder.exists():
        name, folder = given.partition("=")[0], Path(given.partition("=")[2])
    name = name or folder.resolve().name
    if not folder.is_dir():
        raise UserError(
            "a method is a folder of results", got=shorten(given), do="Pass FOLDER, or NAME=FOLDER"
        )
    found: dict[str, Source] = {}
    for top, folders, files in os.walk(folder, followlinks=True):
        here = Path(top)
        folders.sort()
        above = here.parent.resolve()
        if here.is_symlink() and here.resolve() in (above, *above.parents):  # it would never end
            folders.clear()
            continue
        if "manifest.json" in files:
            folders.clear()
            found[_name_item(here, folder)] = _read_run(name, here)
            continue
        for file in sorted(files):
            words = here / f"{file[:-4]}.txt"
            if file.endswith(".mp4") and words.is_file():
                told = read_bytes(words, most=_SENTENCE_BYTES, what="the sentence")
                source = Source(
                    name,
                    told.decode("utf-8", "replace"),
                    here,
                    {VIDEO: here / file, PLAIN_VIDEO: here / file},
                )
                found[_name_item(here / file[:-4], folder)] = source
    if not found:
        raise UserError(
            f"{shorten(folder)} holds no result",
            do="Name a folder of run folders, or of videos NAME.mp4 with their sentences in NAME.txt",
        )
    return name, found


def _name_item(place: Path, folder: Path) -> str:
    name = place.relative_to(folder).as_posix()
    return "clip" if name == "." else name


def _read_run(method: str, folder: Path) -> Source:
    run = open_run(folder)
    done = run.manifest is not None and run.manifest.complete
    videos = {kind: folder / kind for kind in (VIDEO, PLAIN_VIDEO) if done and (folder / kind).is_file()}
    judgement = run.best.judgement if run.best else None
    judged = None
    if judgement and judgement.score is not None:
        judged = Judged(by="planner", success=judgement.verdict is Verdict.SUCCESS, score=judgement.score)
    elif (folder / "fit.json").is_file():  # of a method of the head-to-head: judged by its task
        told = read_json(folder / "fit.json")
        told = told.get("judgement") if isinstance(told, dict) else None
        if isinstance(told, dict) and isinstance(told.get("error"), (int, float)):
            judged = Judged(by="task", success=told.get("success") is True, score=-float(told["error"]))
    return Source(method, run.prompt, folder, videos, judged)


def match_items(
    methods: dict[str, dict[str, Source]], alternatives: int
) -> tuple[dict[str, list[Source]], list[str]]:
    """Sources of every item that enough methods have, all with the same kind of video, and notes on what is missing.

    Raises:
        UserError: Two methods have different sentences for an item, or no item is left.
    """
    items, notes = {}, []
    for name in dict.fromkeys(name for found in methods.values() for name in found):
        sources = [found[name] for found in methods.values() if name in found and found[name].videos]
        sentences = {" ".join(source.sentence.split()): source.method for source in sources}
        if len(sentences) > 1:
            told = "; ".join(f"{method}: {sentence!r}" for sentence, method in sentences.items())
            raise UserError(
                f"the methods have different sentences for {name}", got=shorten(told, 200), do="Rename one"
            )
        staged = all(VIDEO in source.videos for source in sources)
        kind = VIDEO if staged or not any(PLAIN_VIDEO in source.videos for source in sources) else PLAIN_VIDEO
        shown = [source for source in sources if kind in source.videos]
        if kind == PLAIN_VIDEO:
            notes.append(f"{name}: not all have {VIDEO}, so all are shown by {PLAIN_VIDEO}.")
        lacking = [method for method in methods if method not in {source.method for source in shown}]
        if len(shown) < alternatives:
            notes.append(
                f"{name} is left out: {len(shown)} methods have a clip of it, and a set has {alternatives}."
            )
            continue
        if lacking:
            notes.append(f"{name} lacks {', '.join(lacking)}.")
        items[name] = [dataclasses.replace(each, videos={kind: each.videos[kind]}) for each in shown]
    if not items:
        raise UserError(
            f"no item has clips of {alternatives} methods",
            got=" ".join(notes) or "no items",
            do="Give results of the same names in each method's folder, or fewer --alternatives",
        )
    return items, notes


def copy_clip(path: Path) -> tuple[bytes, tuple[int, int, float]]:
    """A video's pictures as a new MP4 file without titles, sound or other data that could tell its maker.

    Returns:
        The file, and width [px], height [px] and duration [s].

    Raises:
        UserError: It is no video, or none that every browser plays.
    """
    out = io.BytesIO()
    try:
        with av.open(str(path)) as source:
            stream = source.streams.video[0]
            code, pixels = stream.codec_context.name, stream.codec_context.pix_fmt
            if (code, pixels) != ("h264", "yuv420p"):
                raise UserError(
                    f"browsers may not play {shorten(path)}",
                    got=f"{code}, {pixels}",
                    do="Convert it: ffmpeg -i IN.mp4 -c:v libx264 -pix_fmt yuv420p OUT.mp4",
                )
            with av.open(out, "w", format="mp4") as file:
                target = file.add_stream_from_template(stream)
                for packet in source.demux(stream):
                    if packet.dts is not None:
                        packet.stream = target
                        file.mux(packet)
            seconds = float((stream.duration or 0) * (stream.time_base or 0))
            return out.getvalue(), (stream.width, stream.height, round(seconds, 2))
    except (OSError, FFmpegError, IndexError, UnicodeError) as error:
        raise UserError(
            f"cannot read the video {shorten(path)}", got=error, do="Check that it is a finished mp4"
        ) from None
