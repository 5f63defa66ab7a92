"""`physagent plan`: what a sentence would make of an object, without simulating it."""

from __future__ import annotations

import dataclasses
import json
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from physagent_jax.cli.options import (
    choose_prompt,
    describe_unknown,
    name_options,
    report_as_options,
    to_spec,
)
from physagent_jax.cli.run import Run
from physagent_jax.scene.config import SignedAxis, SplatEncoding
from physagent_jax.scene.presets import PresetName

if TYPE_CHECKING:
    from physagent_jax.agents.schema import SemanticReply
    from physagent_jax.motion.schema import SceneBrief


@dataclasses.dataclass(frozen=True)
class Plan:
    """Say what a sentence would do to an object, without simulating anything.

    Prints what should be seen and how much of it, the actions, the surroundings, what is held, how long the clip is,
    what was assumed, and what was not understood. What `physagent run` would refuse, a sentence or an object that its
    pictures would not show, is refused: exit code 2.
    """

    object: Path | None = None
    """3D Gaussians (.ply, .spz, ...) or a mesh (.obj, .glb, .stl, .ply)."""
    image: Path | None = None
    """In place of `--object`: a photo, as for `physagent run`."""
    image_box: tuple[float, float, float, float] | None = None
    """As for `physagent run`."""
    image_mask: Path | None = None
    """As for `physagent run`."""
    prompt: str | None = None
    """The wanted motion, in everyday English."""
    sentence: tyro.conf.Positional[str | None] = None
    """In place of `--prompt`."""
    preset: PresetName = PresetName.FAST
    """As for `physagent run`."""
    up: SignedAxis | None = None
    """The file's up axis; default: its card, else +y for glTF (.glb, .gltf), +z for others."""
    splat_encoding: SplatEncoding | None = None
    """As for `physagent run`."""
    kind: str | None = None
    """plant, food, robot, ... (decides what is held); default: its card, else from the file's name."""
    part: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """As for `physagent run`."""
    azimuth: float | None = None
    """The camera's place, in degrees about the vertical: it decides what left is."""
    material: str | None = None
    """As for `physagent run`."""
    anchor: Literal["auto", "none", "base", "top"] = "auto"
    """The part that is held fixed; auto: as the sentence says, else as the kind implies."""
    world: Literal["ground", "free"] | None = None
    """As for `physagent run`."""
    frames: int | None = None
    """Pictures of the clip; default: as many as the sentence needs."""
    reader: Literal["grammar", "model", "both"] = "grammar"
    """Agent that reads the sentence; both: the grammar's reading stands, and the model may doubt it."""
    form: Literal["clauses", "by-clause", "paper"] | None = None
    """As for `physagent run`."""
    llm: str | None = None
    """The language model: http://HOST:PORT/v1 of a server, a GGUF file, or a folder with a model."""
    model: str | None = None
    """Name of the model, as the server of --llm has it."""
    record: Path | None = None
    """Cassette that keeps every request to the model and its answer."""
    replay: Path | None = None
    """Cassette with the model's answers, in place of --llm."""
    json_line: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one line of JSON instead of sentences."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.cli.console import warn
        from physagent_jax.run.brief import make_brief
        from physagent_jax.run.chosen_agents import open_agents
        from physagent_jax.run.first_picture import check_first_picture, is_in_doubt
        from physagent_jax.run.reading import read_for_scene
        from physagent_jax.run.resolve import resolve
        from physagent_jax.scene.body import make_body
        from physagent_jax.scene.fuse import fuse
        from physagent_jax.scene.standing import damp

        given = {name: value for name, value in vars(self).items() if value is not None}
        given["prompt"] = choose_prompt(self.prompt, given.pop("sentence", None))
        with report_as_options():
            run = resolve(to_spec({**vars(Run(out=Path())), **given}), origin="command line")
        for text in run.warnings:
            warn(name_options(text))
        template = run.template
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", UserWarning)
            body = make_body(template.source, template.preset.filling, template.preset.domain, run.base_dir)
        with open_agents(run.spec, run.base_dir, record=self.record) as agents:
            reply = read_for_scene(run, body, agents.semantic.compile).value
        body = run.turn(body, reply)
        template, placed = run.place(body, reply)
        after = make_brief(template, frames_fixed=run.frames_fixed, parts=run.list_parts(body))
        damped = damp(template, body)[1]
        pictured = ()
        if is_in_doubt(body):  # to draw a picture takes as long as all else
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of steps, which nobody takes here
                pictured = check_first_picture(fuse(template, body, reply.force_field), body)
        found = [*(str(each.message) for each in caught), *placed, *([damped] if damped else []), *pictured]
        reply = reply.model_copy(update=dict(notes=(*reply.notes, *map(name_options, found))))
        if self.json_line:
            print(json.dumps({"object": body.reading, **to_json(reply, after)}))
        else:
            print("\n".join(describe_plan(reply, after, body.reading)))
        return 0


def to_json(reply: SemanticReply, brief: SceneBrief) -> dict:
    """The line that ``--json`` prints; ``brief`` is the scene with what the sentence says of it."""
    shown = reply.model_dump(mode="json", exclude_none=True)
    return {
        "parts": [
            each.model_dump(include={"label", "origin", "confidence", "share"}) for each in brief.parts
        ],
        "targets": shown["expectations"],
        "actions": shown["force_field"]["actions"],
        "constraints": shown["force_field"]["constraints"],
        "default_drop": reply.force_field.default_drop,
        "world": {"surroundings": brief.world, **shown["world"]},
        "anchor": {"held": brief.anchored, **shown["anchor"]},
        "frames": brief.frame_count,
        "seconds": round((brief.frame_count - 1) * brief.frame_dt, 6),
        "materials": list(reply.materials),
        "assumptions": list(reply.notes),
        "ignored": list(reply.ignored),
        "not_understood": list(reply.not_understood),
        "unsure": list(reply.unsure),
        "directions": brief.directions.model_dump(mode="json"),
    }


def describe_plan(reply: SemanticReply, brief: SceneBrief, reading: str = "") -> list[str]:
    """The plan in lines of text; ``reading`` says how the object's file was read."""
    from physagent_jax.forces.part import list_parts
    from physagent_jax.forces.schema import VelocityConstraint
    from physagent_jax.report.expectations import describe_motion, list_details
    from physagent_jax.report.force_cards import describe_effect
    from physagent_jax.report.force_terms import describe_region
    from physagent_jax.report.formats import format_window

    table, frame_dt, field = brief.directions, brief.frame_dt, reply.force_field
    lines = ["should be seen:"]
    for each in reply.expectations:
        lines.append(f"  {describe_motion(each, table)}: {', '.join(list_details(each, table, frame_dt))}")
    lines.append("done by:")
    done = ["it is lifted a little and let fall"] * field.default_drop
    for item in (*field.actions, *field.constraints):
        when = "the whole clip" if item.active_time is None else format_window(*item.active_time, frame_dt)
        where = f", on {describe_region(item.region)}" if item.region is not None else ""
        until = item.held_until if isinstance(item, VelocityConstraint) else None
        then = "" if until is None else f", then held until frame {until:g}"
        again = "" if item.gain == 1.0 else f" (k x {item.gain:.3g})"
        done.append(
            f"{describe_effect(item, table)}: magnitude {abs(item.magnitude):.3g}{again}, {when}{where}{then}"
        )
    lines += [f"  {each}" for each in done or ["nothing"]]
    if reading:
        lines.append(f"object: {reading}")
    if brief.parts:
        lines.append(f"parts: {list_parts(brief.parts)}")
    lines.append(f"surroundings: {_describe_world(reply, brief)}")
    lines.append(f"held: {brief.anchored or 'nowhere'}")
    lines.append(f"clip: {brief.frame_count} frames, {(brief.frame_count - 1) * frame_dt:.3g} s")
    lines += [f"assumed: {note}" for note in reply.notes]
    if reply.ignored:
        lines.append(f"ignored: {', '.join(reply.ignored)}")
    if reply.not_understood:
        lines.append(f"not understood: {describe_unknown(reply)}")
    return lines + [f"unsure, so that nothing is called a success: {doubt}" for doubt in reply.unsure]


def _describe_world(reply: SemanticReply, brief: SceneBrief) -> str:
    from physagent_jax.report.directions import describe_direction

    words = {"none": "no gravity", "up": "gravity acts upwards", "down": "gravity acts"}
    if reply.world.gravity:
        parts = [words[reply.world.gravity]]
    elif brief.world == "ground":
        parts = ["gravity acts, it stands on the ground"]
    elif reply.force_field.default_drop:
        parts = ["gravity acts, the ground is below it"]
    else:
        parts = ["it floats in empty space"]
    for each in reply.world.obstacles:
        where = describe_direction(each.direction, brief.directions)
        parts.append(f"a {each.kind} {where} of it, {each.distance:g} body lengths away")
    return "; ".join(parts)
