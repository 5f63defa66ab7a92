"""The loop, round by round: what was tried and seen, what the planner said, what the executor changed."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.schema import Rewrite
from physagent_jax.core.text import split_reason
from physagent_jax.forces.naming import name_places
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import Check, Judgement, Stage, StageVerdict
from physagent_jax.perception.schema import MotionReport, Oscillation, WindowMotion
from physagent_jax.report.agent_traces import show_agent_traces
from physagent_jax.report.charts import draw_motion_charts, draw_physics_charts
from physagent_jax.report.facts import describe_reused_frames
from physagent_jax.report.force_cards import Setting, make_force_cards, read_setting
from physagent_jax.report.formats import (
    UNKNOWN,
    format_count,
    format_fixed,
    format_number,
    format_percent,
    format_plural,
    format_vector,
    spell_out,
)
from physagent_jax.report.layout import (
    make_badge,
    make_facts,
    make_fold,
    make_json_fold,
    make_list,
    make_paragraphs,
    make_table,
    note_missing,
)
from physagent_jax.report.markup import Child, Markup, div, join, span, tag
from physagent_jax.report.media import embed_image
from physagent_jax.run.finished import FinishedRound

MARKS = {True: ("pass", "\u2713 pass"), False: ("failed", "\u2717 fail"), None: ("open", "? not observable")}

STAGE_MARKS = {
    StageVerdict.MET: ("pass", "\u2713 met"),
    StageVerdict.NOT_MET: ("failed", "\u2717 not met"),
    StageVerdict.NOT_SEEN: ("open", "? not seen"),
}


def make_overview(rounds: Sequence[FinishedRound], best: FinishedRound | None) -> Markup:
    """The rounds as linked chips in order."""
    chips = [_make_chip(round_, is_best=round_ is best) for round_ in rounds]
    return tag("nav", *chips, class_="rounds", aria_label="Rounds")


def make_probe_table(probe: Sequence[FinishedRound], best: int | None) -> list[Markup] | None:
    """The rounds on a coarse version of the scene, a line each; None if there were none.

    Args:
        probe: The rounds.
        best: The one whose force field was taken on.
    """
    if not probe:
        return None
    head = ["round", "score", "verdict", "what the planner suggested", "particles"]
    rows: list[list[Child]] = []
    for round_ in probe:
        judgement, record = round_.judgement, round_.simulation
        taken = tag("small", "taken on", class_="remedy") if round_.index == best else None
        rows.append(
            [
                join(str(round_.number), taken),
                format_fixed(judgement.score if judgement else None),
                make_badge(judgement.verdict if judgement else None),
                name_places(judgement.suggestion, round_.force_field) or UNKNOWN if judgement else UNKNOWN,
                format_count(record.particle_count) if record else UNKNOWN,
            ]
        )
    lead = "Force fields were first tried on a coarse version of the scene. Round 1 begins with the best of them."
    return [
        tag("h3", "Coarse rounds"),
        tag("p", lead),
        make_table(head, rows, numeric=(1, 4), class_="compact"),
    ]


def make_round_card(
    round_: FinishedRound,
    previous: FinishedRound | None,
    *,
    is_best: bool,
    video: Child,
    with_plots: bool,
) -> Markup:
    """One round.

    Args:
        round_: Which.
        previous: The round before, to mark what changed in the force field.
        is_best: Whether the top of the page shows this one.
        video: Its player.
        with_plots: Whether to add its plots (the best round's stand in a section of their own).
    """
    setting = read_setting(round_.scene)
    parts = [
        _make_head(round_, is_best),
        div("split", div("clip", video), _show_forces(round_, previous, setting)),
        _describe_reuse(round_),
        _show_overlay(round_),
        _show_judgement(round_.judgement, round_.force_field),
        _show_rewrite(round_.rewrite, round_.number + 1),
        show_agent_traces(
            {"planner": round_.planner_trace, "executor": round_.executor_trace}, round_.failed_calls
        ),
        _show_perception(round_.motion),
        _show_plots(round_) if with_plots else None,
    ]
    return tag("article", *parts, class_="round", id=round_.clip)


def _make_chip(round_: FinishedRound, *, is_best: bool) -> Markup:
    judgement = round_.judgement
    score = "not judged"
    if judgement:
        score = judgement.verdict if judgement.score is None else f"score {format_fixed(judgement.score)}"
    kind = "open" if judgement is None else "success" if judgement.verdict == "SUCCESS" else "fail"
    return tag(
        "a",
        tag("strong", f"Round {round_.number}"),
        span("quiet", score),
        span("quiet star", "shown above") if is_best else None,
        href=f"#{round_.clip}",
        class_=f"chip {kind}",
    )


def _make_head(round_: FinishedRound, is_best: bool) -> Markup:
    judgement = round_.judgement
    score = None
    if judgement and judgement.score is not None:
        score = span("score", "score ", tag("b", format_fixed(judgement.score)))
    star = span("badge best", "best") if is_best else None
    title = tag("h3", f"Round {round_.number}")
    return tag("header", title, make_badge(judgement.verdict if judgement else None), star, score)


def _show_forces(round_: FinishedRound, previous: FinishedRound | None, setting: Setting) -> Markup:
    if round_.force_field is None:
        return note_missing("The force field of this round is missing.")
    return make_force_cards(round_.force_field, setting, previous=previous.force_field if previous else None)


def _describe_reuse(round_: FinishedRound) -> Markup | None:
    if not round_.reused_frames:
        return None
    text = f"Taken over instead of simulated: {describe_reused_frames(round_.reused_frames)}."
    return tag("p", text, class_="quiet")


def _show_overlay(round_: FinishedRound) -> Markup | None:
    if round_.overlay is None:
        return None
    caption = tag("figcaption", "What perception followed: the object\u2019s mask and the tracked points.")
    return tag(
        "figure", embed_image(round_.overlay, "mask and tracks drawn on frames"), caption, class_="overlay"
    )


def _show_judgement(
    judgement: Judgement | None, force_field: ForceField | None
) -> list[Markup | None] | Markup:
    if judgement is None:
        return note_missing("The planner\u2019s judgement of this round is missing.")
    rows = [_show_check(check, force_field) for check in judgement.checks]
    suggestion = None
    if judgement.suggestion:
        why, rest = split_reason(name_places(judgement.suggestion, force_field))
        details = (
            make_fold("In figures, and what the planner suggests", make_paragraphs(rest)) if rest else None
        )
        suggestion = div("callout", tag("p", tag("strong", why), class_="why"), details)
    checks = make_table(
        ["question", "expected", "observed", "result", "margin", "confidence", "score"],
        rows,
        class_="checks",
        numeric=(4, 5, 6),
    )
    notes = make_list("What the planner says of it", judgement.notes)
    if not rows:
        return [suggestion, tag("p", "The planner gave its verdict without single checks."), notes]
    stages = _show_stages(judgement.stages)
    note = (
        "Margin: how far inside of its limits a value lies, in tolerances; 1 is what is aimed at, below 0 is outside. "
        "Confidence: the chance that the result would be the same without errors of perception."
    )
    fold = make_fold("What the planner checked", *stages, checks, tag("p", note, class_="quiet"), notes)
    return [suggestion, fold]


def _show_stages(stages: Sequence[Stage]) -> list[Markup]:
    """The table of the sentence's steps; none if it has only one."""
    if len(stages) < 2:
        return []
    rows: list[list[Child]] = []
    for number, stage in enumerate(stages, 1):
        kind, word = STAGE_MARKS[stage.verdict]
        frames = f"{stage.window[0]:.0f}\u2013{stage.window[1]:.0f}"
        words = stage.words or UNKNOWN
        rows.append([str(number), words, frames, stage.asked, stage.measured, span(f"result {kind}", word)])
    table = make_table(["stage", "words", "frames", "asked", "measured", "result"], rows, class_="checks")
    return [tag("h4", "The sentence stage by stage"), table]


def _show_check(check: Check, force_field: ForceField | None) -> list[Child]:
    kind, word = MARKS[check.passed]
    remedy = tag("small", name_places(check.remedy, force_field), class_="remedy") if check.remedy else None
    result = span(f"result {kind}", word)
    return [
        join(check.question, remedy),
        check.expected,
        check.observed,
        result,
        UNKNOWN if check.margin is None else format_fixed(check.margin),
        UNKNOWN if check.passed is None else format_percent(check.confidence),
        format_fixed(check.score),
    ]


def _show_rewrite(rewrite: Rewrite | None, next_round: int) -> Markup | None:
    if rewrite is None:
        return None
    rules = None
    if rewrite.rules_applied:
        chips = [span("rule", spell_out(name)) for name in rewrite.rules_applied]
        rules = div("rules", span("quiet", "hard rules applied:"), join(*chips))
    told = [name_places(change, rewrite.force_field) for change in rewrite.changes]
    changes = tag("ul", [tag("li", change) for change in told])
    if not rewrite.changes:
        changes = tag("p", "Nothing was changed.")
    title = tag("strong", f"The executor changed, for round {next_round}")
    return div("callout executor", title, changes, rules)


def _show_perception(report: MotionReport | None) -> Markup:
    if report is None:
        return note_missing("The motion report of this round is missing.")
    return make_fold(
        "What perception measured",
        make_paragraphs(report.text),
        _make_window_table(report.windows),
        div("columns", _list_course(report), _list_quality(report)),
        make_list("What weakened a measurement", report.quality.notes),
        make_json_fold("Motion report as JSON", report),
    )


def _make_window_table(windows: Sequence[WindowMotion]) -> Markup:
    head = ["frames", "net displacement", "path", "farthest", "turn", "stretch", "volume", "not observable"]
    rows = []
    for w in windows:
        stretch = None if w.stretch is None else [w.stretch[axis][axis] for axis in range(3)]
        turn = "\u2014" if w.rotation_degrees is None else f"{format_fixed(w.rotation_degrees, 1)}\u00b0"
        reasons = "; ".join(f"{spell_out(name)}: {why}" for name, why in w.unobservable.items())
        farthest = format_vector(w.peak_displacement)
        if w.peak_frame is not None:
            farthest += f" at frame {w.peak_frame}"
        rows.append(
            [
                f"{w.first}\u2013{w.last}",
                format_vector(w.displacement),
                format_fixed(w.path_length),
                farthest,
                turn,
                format_vector(stretch),
                format_fixed(w.volume_ratio),
                reasons or "\u2014",
            ]
        )
    note = tag("p", "Lengths in body lengths; vectors and stretch along world x, y, z.", class_="quiet")
    return join(make_table(head, rows, class_="dense"), note)


def _list_course(report: MotionReport) -> Markup:
    onset, settle = report.onset_frame, report.settle_frame
    rows = [
        ("first visible motion", "none seen" if onset is None else f"frame {onset}"),
        ("at rest again", "not within the clip" if settle is None else f"frame {settle}"),
        ("oscillation", _describe_oscillation(report.oscillation)),
    ]
    return make_facts(rows)


def _describe_oscillation(swing: Oscillation | None) -> str:
    if swing is None:
        return "none"
    size = f"{format_number(swing.frequency_hz)} Hz, amplitude {format_number(swing.amplitude)} body lengths"
    return f"{size} along {format_vector(swing.direction)}, {format_plural(swing.reversals, 'reversal')}"


def _list_quality(report: MotionReport) -> Markup:
    quality = report.quality
    leaves = quality.leaves_frame
    rows = [
        ("tracks kept", format_percent(quality.tracks_kept)),
        ("fit residual", f"{format_number(quality.fit_residual)} body lengths"),
        ("depth noise", f"{format_number(quality.depth_noise)} body lengths"),
        ("object in frame 0", f"{format_percent(quality.mask_fraction)} of the picture"),
        ("leaves the picture", "never" if leaves is None else f"from frame {leaves}"),
    ]
    return make_facts(rows)


def _show_plots(round_: FinishedRound) -> Markup | None:
    charts = [draw_motion_charts(round_), draw_physics_charts(round_)]
    if not any(charts):
        return None
    return make_fold("Plots of this round", *charts)
