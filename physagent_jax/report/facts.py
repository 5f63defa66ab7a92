"""Facts about the scene, the simulation, the cost and how to make the run again."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.report.directions import make_direction_table
from physagent_jax.report.force_terms import describe_force_term, describe_span
from physagent_jax.report.formats import (
    UNKNOWN,
    format_count,
    format_number,
    format_percent,
    format_plural,
    format_quantity,
    format_seconds,
    format_vector,
    spell_out,
)
from physagent_jax.report.layout import make_facts, make_fold, make_table, note_missing
from physagent_jax.report.markup import Child, Markup, div, join, span, tag
from physagent_jax.run.finished import FinishedRound
from physagent_jax.run.manifest import AgentCost, Manifest, Stages
from physagent_jax.scene.config import (
    Anchor,
    Boundary,
    Box,
    Constraint,
    HalfSpace,
    Material,
    Mesh,
    SceneConfig,
    Sphere,
)
from physagent_jax.scene.materials import describe_material
from physagent_jax.simulation.record import SimulationRecord

STAGE_NAMES = {
    "prepare": "prepare the scene",
    "compile": "compile",
    "simulate": "simulate",
    "render": "render",
    "perceive": "perceive",
    "agents": "agents",
    "write": "write files",
    "probe": "coarse rounds",
}


def make_scene_facts(scene: SceneConfig, record: SimulationRecord | None) -> list[Markup]:
    """The table of the simulated scene, and the reasons for its values."""
    columns = [
        _make_column("Object", _list_object(scene, record)),
        _make_column("Material", _list_material(scene.material)),
        _make_column("World", _list_world(scene)),
        _make_column("Camera and clip", _list_camera(scene)),
    ]
    parts = [div("columns", *columns)]
    if scene.material_regions:
        head = ["centre [m]", "half size [m]", "model", "properties", "why"]
        rows = [
            [
                format_vector(region.point),
                format_vector(region.half_size),
                *_make_material_cells(region.material),
            ]
            for region in scene.material_regions
        ]
        parts += [tag("h3", "Regions of other material"), make_table(head, rows)]
    return parts


def make_simulation_facts(round_: FinishedRound) -> Markup:
    """The table of the best rollout."""
    record = round_.simulation
    if record is None:
        return note_missing(f"simulation.json of round {round_.number} is missing: no simulation facts.")
    smallest, largest = min(record.substep_dt, default=None), max(record.substep_dt, default=None)
    used = format_quantity(smallest, "s")
    if smallest != largest:
        used = f"{used} to {format_quantity(largest, 's')}"
    share = (
        ""
        if largest is None or not record.stable_dt
        else f" ({format_percent(largest / record.stable_dt)} of it)"
    )
    return join(
        make_facts(
            [
                (
                    "substeps",
                    f"{format_count(record.substeps)} over {format_plural(len(record.substep_dt), 'frame interval')}",
                ),
                (
                    "grid window",
                    " \u00d7 ".join(format_count(nodes) for nodes in record.grid_shape) + " nodes",
                ),
                (
                    "stable bound at the start",
                    "none" if record.stable_dt is None else format_quantity(record.stable_dt, "s"),
                ),
                ("substep used", used + share),
                ("particles stopped at the wall", _describe_stopped(record.stopped_particles)),
                ("redone frames", "none" if not record.redone_frames else str(len(record.redone_frames))),
                ("taken over", describe_reused_frames(round_.reused_frames))
                if round_.reused_frames
                else None,
            ]
        ),
        _make_redone_table(record),
    )


def make_cost_facts(manifest: Manifest) -> Markup:
    """The table of seconds and tokens."""
    return div("columns cost", _make_stage_table(manifest.stages), _make_agent_table(manifest.agents))


def describe_reproduction(manifest: Manifest) -> list[Child]:
    """Describe the way to make the run again, and the versions that made it."""
    return [
        tag("p", "The run was started with"),
        tag("pre", tag("code", manifest.command), class_="command"),
        tag("p", "In this folder, its best scene replays without any agent with"),
        tag("pre", tag("code", "physagent simulate scene.json"), class_="command"),
        make_facts(
            [
                ("seed", str(manifest.seed)),
                ("revision", manifest.git_revision or "not a git working tree"),
                ("platform", manifest.platform),
                ("kernels", manifest.kernels),
                ("versions", _describe_versions(manifest)),
            ]
        ),
        _make_input_table(manifest),
    ]


def _make_column(title: str, rows: Sequence[tuple[str, Child] | None]) -> Markup:
    return tag("section", tag("h3", title), make_facts(rows), class_="column")


def _add_reason(value: Child, reason: str) -> Markup:
    return join(value, tag("small", reason, class_="reason") if reason else None)


def _list_object(scene: SceneConfig, record: SimulationRecord | None) -> list[tuple[str, Child] | None]:
    source = scene.source
    return [
        ("name", f"{source.name or source.path} ({source.kind})"),
        ("file", tag("code", source.path)),
        ("longest side", format_quantity(source.extent, "m")),
        ("Gaussians", format_count(record.gaussian_count)) if record else None,
        ("particles", format_count(record.particle_count)) if record else None,
        ("inside", "filled with particles" if scene.filling.enabled else "not filled"),
        ("anchor", _add_reason(_describe_anchor(scene.anchor), scene.anchor.reason)),
    ]


def describe_property(value: float | bool, unit: str) -> str:
    """A property of `scene.materials.describe_material` as people read it: "100 kPa", "30\u00b0", "yes"."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if unit == "\u00b0":
        return f"{format_number(value)}{unit}"
    if unit in ("", "kg/m\u00b3"):
        return f"{format_number(value)} {unit}".rstrip()
    return format_quantity(value, unit)


def _list_material(material: Material) -> list[tuple[str, Child]]:
    acting = [(name, describe_property(value, unit)) for name, value, unit in describe_material(material)]
    reason = [("from", material.reason)] if material.reason else []
    return [("model", spell_out(material.model.value)), *acting, *reason]


def _make_material_cells(material: Material) -> list[Child]:
    """Model, properties and reason of a region."""
    acting = ", ".join(
        f"{name} {describe_property(value, unit)}" for name, value, unit in describe_material(material)
    )
    return [spell_out(material.model.value), acting, material.reason or UNKNOWN]


def _list_world(scene: SceneConfig) -> list[tuple[str, Child] | None]:
    acts = scene.always_gravity or scene.force_field.default_drop
    gravity = f"on, {format_vector(scene.gravity, 1)} m/s\u00b2" if acts else "off"
    transfer = scene.transfer
    damping = f", damping {format_number(transfer.damping_rate)} 1/s" if transfer.damping_rate else ""
    walls = [tag("li", describe_boundary(boundary)) for boundary in scene.boundaries]
    constraints = [tag("li", describe_constraint(constraint)) for constraint in scene.constraints]
    viewer = make_direction_table(scene.camera)
    pushes = [tag("li", describe_force_term(term, viewer)) for term in scene.forces]
    return [
        (
            "domain",
            f"{format_number(scene.domain.size)} m cube, {format_count(scene.domain.cells)} cells a side",
        ),
        ("grid spacing dx", format_quantity(scene.domain.dx, "m")),
        ("transfer", f"{transfer.scheme.upper()}{damping}"),
        ("gravity", gravity),
        ("boundaries", tag("ul", walls) if walls else "none"),
        ("constraints", tag("ul", constraints)) if constraints else None,
        ("forces", tag("ul", pushes)) if pushes else None,
    ]


def _list_camera(scene: SceneConfig) -> list[tuple[str, Child] | None]:
    camera, timing, picture = scene.camera, scene.timing, scene.rendering
    azimuth, elevation = format_number(camera.azimuth_degrees), format_number(camera.elevation_degrees)
    view = f"azimuth {azimuth}\u00b0, elevation {elevation}\u00b0"
    target = "the domain\u2019s centre" if camera.target is None else f"{format_vector(camera.target)} m"
    scaling = scene.scaling
    return [
        ("clip", f"{describe_clip(scene)}, {format_quantity(timing.frame_dt, 's')} a frame"),
        ("pictures", f"{picture.width} \u00d7 {picture.height} px"),
        ("view", view),
        ("looks at", f"{target} from {format_quantity(camera.distance, 'm')}"),
        ("field of view", f"{format_number(camera.fov_degrees)}\u00b0, vertical"),
        ("preset", scene.preset),
        ("what magnitude 1 means", scaling.reason) if scaling and scaling.reason else None,
    ]


def _describe_anchor(anchor: Anchor) -> str:
    if anchor.kind == "none":
        return "none: the object is free"
    if anchor.kind == "box":
        return f"a box about {format_vector(anchor.point)} m, half size {format_vector(anchor.half_size)} m"
    if anchor.kind == "mask":
        return f"the Gaussians of {anchor.mask_path}"
    where = "lowest" if anchor.kind == "base" else "highest"
    return f"the {where} {format_number(100 * anchor.fraction)} % of its height"


def describe_clip(scene: SceneConfig) -> str:
    """Describe the clip's length."""
    timing = scene.timing
    return f"{format_plural(timing.frame_count, 'frame')}, {format_seconds((timing.frame_count - 1) * timing.frame_dt)}"


def describe_boundary(boundary: Boundary) -> str:
    """A boundary in words."""
    if boundary.kind == "domain_box":
        return f"walls of the domain, {boundary.padding} cells thick"
    if boundary.kind == "cuboid":
        words = f"material about {format_vector(boundary.point)} m, half size {format_vector(boundary.half_size)} m, "
        words += (
            f"is moved at {format_vector(boundary.velocity)} m/s" if any(boundary.velocity) else "is held"
        )
        return words + describe_span(boundary.start, boundary.end)
    words = f"{_describe_solid(boundary)}, {boundary.surface.value}"
    if boundary.friction:
        words += f", friction {format_number(boundary.friction)}"
    if any(boundary.velocity):
        words += f", moving at {format_vector(boundary.velocity)} m/s"
    return words + describe_span(boundary.start, boundary.end)


def _describe_solid(obstacle: HalfSpace | Sphere | Box | Mesh) -> str:
    if obstacle.kind == "half_space":
        return f"plane through {format_vector(obstacle.point)} m facing {format_vector(obstacle.normal)}"
    if obstacle.kind == "mesh":
        return f"mesh {obstacle.path} at {format_vector(obstacle.position)} m, scale {format_number(obstacle.scale)}"
    place = f"about {format_vector(obstacle.point)} m"
    if obstacle.kind == "sphere":
        words = f"{place}, radius {format_quantity(obstacle.radius, 'm')}"
    else:
        words = f"{place}, half size {format_vector(obstacle.half_size)} m"
    return f"{'container' if obstacle.container else 'solid'} {obstacle.kind} {words}"


def describe_constraint(constraint: Constraint) -> str:
    """A particle constraint in words."""
    if constraint.kind == "particle_release":
        reach = f"{format_number(constraint.start_position)} to {format_number(constraint.end_position)} m"
        way = f"{format_plural(constraint.layers, 'layer')} along {format_vector(constraint.normal)} from {reach}"
        return f"held, then let go in {way}" + describe_span(constraint.start, constraint.end)
    where = f"particles about {format_vector(constraint.point)} m"
    if constraint.kind == "particle_impulse":
        if constraint.delta_velocity is not None:
            return f"{where} get {format_vector(constraint.delta_velocity)} m/s at {format_seconds(constraint.start)}"
        return f"{where} get {format_vector(constraint.force)} N each at {format_seconds(constraint.start)}"
    if constraint.kind == "particle_translation":
        words = f"{where} move at {format_vector(constraint.velocity)} m/s"
    else:
        speed = f"{format_number(constraint.angular_velocity)} rad/s"
        words = f"{where} turn about {format_vector(constraint.normal)} at {speed}"
    return words + describe_span(constraint.start, constraint.end)


def _describe_stopped(particle_steps: int) -> str:
    return "none" if particle_steps == 0 else f"{format_count(particle_steps)} times"


def describe_reused_frames(frames: int) -> str:
    """Describe the frames that were not simulated again."""
    return f"frames 0 to {frames - 1} of the round before, whose forces are the same until then"


def _make_redone_table(record: SimulationRecord) -> Markup | None:
    if not record.redone_frames:
        return None
    rows = [[str(frame), why] for frame, why in sorted(record.redone_frames.items())]
    return make_table(["redone frame", "because"], rows)


def _make_stage_table(stages: Stages) -> Markup:
    entries = [(title, getattr(stages, name)) for name, title in STAGE_NAMES.items()]
    total = sum(value for _, value in entries)
    bar = div(
        "stack",
        *[
            tag(
                "i",
                style=f"flex-grow:{value:.4g}",
                class_=f"s{index}",
                title=f"{title}: {format_seconds(value)}",
            )
            for index, (title, value) in enumerate(entries)
            if value > 0
        ],
    )
    rows = [
        [
            span("stage", span(f"swatch block s{index}"), title),
            format_seconds(value),
            format_percent(value / total if total else None),
        ]
        for index, (title, value) in enumerate(entries)
        if value > 0 or title != STAGE_NAMES["probe"]
    ]
    rows.append([tag("strong", "in all"), tag("strong", format_seconds(total)), ""])
    time = make_table(["stage", "wall time", "share"], rows, numeric=(1, 2), class_="compact")
    return tag("section", tag("h3", "Time"), bar if total else None, time, class_="column")


def _make_agent_table(agents: tuple[AgentCost, ...]) -> Markup:
    head = ["agent", "made by", "calls", "tokens in", "tokens out", "waited for models", "time"]
    rows = [
        [
            a.agent,
            a.implementation,
            f"{format_count(a.calls)}, {format_count(a.failed_calls)} failed"
            if a.failed_calls
            else format_count(a.calls),
            *_format_cost(*_list_cost(a)),
        ]
        for a in agents
    ]
    if len(agents) > 1:
        sums = (sum(each) for each in zip(*[_list_cost(a) for a in agents]))
        rows.append(["all", "", format_count(sum(a.calls for a in agents)), *_format_cost(*sums)])
    body = (
        make_table(head, rows, numeric=(2, 3, 4, 5, 6), class_="compact")
        if rows
        else tag("p", "No agent took part.")
    )
    return tag("section", tag("h3", "Agents"), body, class_="column")


def _list_cost(cost: AgentCost) -> tuple[int, int, float, float]:
    return cost.input_tokens, cost.output_tokens, cost.latency_seconds, cost.seconds


def _format_cost(read: int, written: int, waited: float, seconds: float) -> list[str]:
    return [format_count(read), format_count(written), format_seconds(waited), format_seconds(seconds)]


def _describe_versions(manifest: Manifest) -> str:
    return ", ".join(f"{name}\u00a0{version}" for name, version in manifest.versions.items()) or UNKNOWN


def _make_input_table(manifest: Manifest) -> Markup | None:
    if not manifest.inputs:
        return None
    rows = [
        [tag("code", name), tag("code", digest, class_="hash")] for name, digest in manifest.inputs.items()
    ]
    return make_fold("Input files and their SHA-256", make_table(["file", "hash"], rows))
