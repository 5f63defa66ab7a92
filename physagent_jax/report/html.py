"""One page that tells a run: what was asked, understood, tried, seen and decided, and what it cost."""

from __future__ import annotations

import base64
import hashlib
import os
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

from physagent_jax import __version__
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.core.text import split_reason
from physagent_jax.forces.naming import name_places
from physagent_jax.report.agent_traces import show_agent_traces, show_refused_readings
from physagent_jax.report.charts import draw_motion_charts, draw_physics_charts
from physagent_jax.report.facts import (
    describe_clip,
    describe_reproduction,
    make_cost_facts,
    make_scene_facts,
    make_simulation_facts,
)
from physagent_jax.report.force_cards import read_setting
from physagent_jax.report.formats import format_count, format_fixed, format_seconds
from physagent_jax.report.layout import (
    make_badge,
    make_facts,
    make_fold,
    make_json_fold,
    make_list,
    make_paragraphs,
    make_section,
    note_missing,
)
from physagent_jax.report.markup import Markup, div, join, raw, tag
from physagent_jax.report.media import Clip, embed_filmstrip, embed_player, load_clip
from physagent_jax.report.rounds import make_overview, make_probe_table, make_round_card
from physagent_jax.report.truth import make_truth_table
from physagent_jax.report.words import make_words_section
from physagent_jax.run.finished import FinishedRound, FinishedRun, open_run
from physagent_jax.run.manifest import AgentCost
from physagent_jax.run.stopping import STOP_REASONS
from physagent_jax.run.store import REPORT

SECTIONS = {
    "words": "From words to forces",
    "rounds": "Rounds",
    "measurements": "Measurements",
    "scene": "Scene",
    "cost": "Cost",
    "again": "Make it again",
}


HERO = "player"  # id of the video at the top
_GENERATOR = "physagent-jax"
_HEAD_BYTES = 1024  # within which a page says who has made it


def write_report(run_dir: str | Path, *, overwrite: bool = False) -> Path:
    """Write ``report.html`` into a run folder, from the folder's files alone.

    The page needs no other file and no network: style, script, pictures and videos are inside it (a video
    above 22 MB is linked by its name in the folder, because browsers refuse it inside a page). Files that
    are missing or broken are named on the page, and the rest is shown.

    Args:
        run_dir: The run folder.
        overwrite: Whether to replace a ``report.html`` that is not a page of this function's.

    Returns:
        The page's path.

    Raises:
        UserError: The folder holds nothing of a run, or the page cannot be written.
    """
    run = open_run(run_dir)
    path = Path(run_dir) / REPORT
    if not overwrite and os.path.lexists(path) and not _is_ours(path):
        raise UserError(
            f"{path} exists and was not written by {_GENERATOR}", do="Move it away, or pass --overwrite"
        )
    write_text(path, render_page(run))
    return path


def _is_ours(path: Path) -> bool:
    if not path.is_file():
        return False
    with open(path, "rb") as file:
        return f'name="generator" content="{_GENERATOR} '.encode() in file.read(_HEAD_BYTES)


def render_page(run: FinishedRun) -> str:
    """The whole page as text."""
    players = _Players(run)
    body = tag(
        "main",
        _make_header(run),
        _make_notices(run),
        _make_hero(run, players),
        _make_words(run),
        _make_rounds(run, players),
        _make_measurements(run),
        _make_scene(run),
        _make_cost(run),
        _make_reproduction(run),
        tag("footer", f"Written by physagent-jax {__version__} from the files of this run folder."),
    )
    script = _read_asset("report.js")
    head = [
        tag("meta", charset="utf-8"),
        tag("meta", name="generator", content=f"{_GENERATOR} {__version__}"),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", http_equiv="Content-Security-Policy", content=_make_policy(script)),
        tag("meta", name="color-scheme", content="light dark"),
        tag("title", run.prompt or "PhysAgent run"),
        tag("style", raw(_read_asset("report.css"))),
    ]
    page = tag("html", tag("head", *head), tag("body", body, tag("script", raw(script))), lang="en")
    return f"<!DOCTYPE html>\n{page}\n"


class _Players:
    """Video elements; a video that the folder holds twice is embedded once."""

    def __init__(self, run: FinishedRun):
        self.run = run
        self.hero_clip = load_clip(run.video) or load_clip(run.best.video if run.best else None)
        self.hero_group = run.best.clip if run.best else "clip"

    def hero(self) -> Markup:
        if self.hero_clip is None:
            return note_missing("There is no video yet.")
        return self._embed(self.hero_clip, self.hero_group, id_=HERO)

    def of(self, round_: FinishedRound) -> Markup:
        clip = load_clip(round_.video)
        if clip is None:
            return note_missing("The video of this round is missing.")
        same = self.hero_clip is not None and clip.digest == self.hero_clip.digest
        return self._embed(clip, round_.clip, same_as=HERO if same else None)

    def _embed(self, clip: Clip, group: str, **options: str | None) -> Markup:
        return embed_player(clip, group=group, frame_dt=self.run.frame_dt, folder=self.run.folder, **options)


def _make_header(run: FinishedRun) -> Markup:
    verdict = run.manifest.verdict if run.manifest else None
    scene = run.best_scene
    name = (scene.source.name or Path(scene.source.path).stem) if scene else ""
    links = [tag("a", title, href=f"#{id_}") for id_, title in SECTIONS.items()]
    # The quotation marks belong to the page, not to the prompt.
    title = tag("h1", join("\u201c", run.prompt, "\u201d") if run.prompt else "A run without a prompt")
    kicker = tag("p", " \u00b7 ".join(filter(None, ["PhysAgent run", name])), class_="kicker")
    verdict_line = tag("p", make_badge(verdict), explain_verdict(run), class_="verdict")
    return tag("header", kicker, title, verdict_line, tag("nav", *links, class_="contents"), class_="page")


def explain_verdict(run: FinishedRun) -> str:
    """Two plain sentences on a failure: why it is one, and why the run ended; one on a success."""
    manifest, best = run.manifest, run.best
    if manifest is None or best is None or best.judgement is None or not manifest.complete:
        return ""
    if manifest.verdict == "SUCCESS":
        return "The clip shows what the sentence asks for."
    why = split_reason(name_places(best.judgement.suggestion, best.force_field))[0]
    why = why or "The clip does not show what the sentence asks for."
    return f"{why} No further round was made: {STOP_REASONS[manifest.stopped]}." if manifest.stopped else why


def _make_notices(run: FinishedRun) -> list[Markup | None]:
    manifest = run.manifest
    notices = []
    if manifest and not manifest.complete:
        notices.append(
            div("notice", tag("strong", "This run is not complete. "), "It is under way, or was stopped.")
        )
    if manifest and manifest.warnings:
        notices.append(div("notice", make_list("Warnings", manifest.warnings)))
    if run.problems:
        notices.append(div("notice", make_list("Missing from the run folder", run.problems)))
    return notices


def _make_hero(run: FinishedRun, players: _Players) -> Markup:
    best = run.best
    text = best.motion.text if best and best.motion else ""
    story = make_fold("The motion in figures", make_paragraphs(text)) if text else None
    story = story or note_missing("The motion report is missing.")
    strip = embed_filmstrip(players.hero_clip, run.frame_dt) if players.hero_clip else None
    side = div("side", tag("h2", "At a glance"), _make_glance(run), tag("h2", "What happened"), story)
    return tag("section", div("hero-grid", div("clip", players.hero()), side), strip, class_="hero")


def _make_glance(run: FinishedRun) -> Markup:
    manifest, best, scene = run.manifest, run.best, run.best_scene
    record = best.simulation if best else None
    score = best.judgement.score if best and best.judgement else None
    tokens = _describe_tokens(manifest.agents) if manifest else ""
    total = sum(manifest.stages.model_dump().values()) if manifest else 0
    return make_facts(
        [
            ("score", f"{format_fixed(score)} of 1") if score is not None else None,
            ("rounds", f"{len(run.rounds)}, the best is round {best.number}") if best else None,
            ("ended because", STOP_REASONS[manifest.stopped]) if manifest and manifest.stopped else None,
            ("coarse rounds before", str(len(run.probe))) if run.probe else None,
            ("clip", describe_clip(scene)) if scene else None,
            ("particles", format_count(record.particle_count)) if record else None,
            ("Gaussians", format_count(record.gaussian_count)) if record else None,
            ("wall time", format_seconds(total)) if total else None,
            ("tokens", tokens) if tokens else None,
        ]
    )


def _describe_tokens(agents: Sequence[AgentCost]) -> str:
    """Tokens of all calls, and the time that was waited for them; empty if no agent took part."""
    if not agents:
        return ""
    read, written = sum(a.input_tokens for a in agents), sum(a.output_tokens for a in agents)
    waited = sum(a.latency_seconds for a in agents)
    if not read + written + waited:
        return "none, rules only"
    return f"{format_count(read)} in, {format_count(written)} out, {format_seconds(waited)} waited"


def _make_words(run: FinishedRun) -> Markup:
    lead = "What the semantic agent understood, word by word, and the force field that it compiled."
    if run.semantic is None:
        body = [note_missing("semantic.json is missing: what was understood is not known.")]
    else:
        body = make_words_section(run.prompt, run.semantic, read_setting(run.best_scene))
    traces = show_agent_traces(
        {"semantic agent": run.semantic_trace}, {"semantic agent": run.semantic_failed}
    )
    traces += show_refused_readings(run.refused)
    return make_section("words", SECTIONS["words"], *body, *traces, lead=lead)


def _make_rounds(run: FinishedRun, players: _Players) -> Markup:
    lead = (
        "Each round simulates a force field, looks at the pictures, and judges them against the sentence. "
        "If they fail, the force field is rewritten for the next round. Clips here are the plain pictures that "
        "perception gets; the video at the top is drawn for people."
    )
    cards, previous = [], None
    for round_ in run.rounds:
        is_best = round_ is run.best
        video = players.of(round_)
        cards.append(make_round_card(round_, previous, is_best=is_best, video=video, with_plots=not is_best))
        previous = round_
    if not cards:
        cards.append(note_missing("There is no round yet."))
    coarse = make_probe_table(run.probe, run.manifest.probe_best if run.manifest else None)
    chips = make_overview(run.rounds, run.best)
    return make_section("rounds", SECTIONS["rounds"], coarse, chips, *cards, lead=lead)


def _make_measurements(run: FinishedRun) -> Markup:
    best = run.best
    if best is None:
        return make_section(
            "measurements", SECTIONS["measurements"], note_missing("Nothing has been measured yet.")
        )
    truth = best.simulation.truth if best.simulation else None
    compared = make_truth_table(best.motion, truth) if best.motion and truth else None
    lead = (
        f"Round {best.number}. Solid lines are what perception saw in the pictures, dashed lines what the "
        "particles did. Point at a plot to read values; click to go to that frame of the video."
    )
    return make_section(
        "measurements",
        SECTIONS["measurements"],
        tag("h3", "Motion"),
        draw_motion_charts(best) or note_missing("Neither perceived nor true motion is stored."),
        tag("h3", "Perception against truth"),
        compared or note_missing("The comparison needs both the motion report and the true motion."),
        tag("h3", "Physics"),
        draw_physics_charts(best) or note_missing("simulation.json is missing: no physics to plot."),
        make_simulation_facts(best) if best.simulation else None,
        lead=lead,
    )


def _make_scene(run: FinishedRun) -> Markup:
    scene = run.best_scene
    if scene is None:
        return make_section(
            "scene", SECTIONS["scene"], note_missing("scene.json is missing: the scene is not known.")
        )
    record = run.best.simulation if run.best else None
    return make_section(
        "scene", SECTIONS["scene"], *make_scene_facts(scene, record), make_json_fold("Scene as JSON", scene)
    )


def _make_cost(run: FinishedRun) -> Markup:
    body = make_cost_facts(run.manifest) if run.manifest else note_missing("manifest.json is missing.")
    return make_section("cost", SECTIONS["cost"], body)


def _make_reproduction(run: FinishedRun) -> Markup:
    manifest = run.manifest
    if manifest is None:
        return make_section("again", SECTIONS["again"], note_missing("manifest.json is missing."))
    return make_section(
        "again",
        SECTIONS["again"],
        *describe_reproduction(manifest),
        make_json_fold("Manifest as JSON", manifest),
    )


def _make_policy(script: str) -> str:
    """Let the browser refuse any other source, and any script but the page's own."""
    digest = base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")
    return (
        "default-src 'none'; img-src data:; media-src data: 'self' file:; style-src 'unsafe-inline'; "
        f"script-src 'sha256-{digest}'"
    )


def _read_asset(name: str) -> str:
    return resources.files("physagent_jax.report").joinpath("assets", name).read_text(encoding="utf-8")
