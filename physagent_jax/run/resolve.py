"""From a `RunSpec` to what the loop works with: files read and hashed, names looked up, defaults filled in."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.core.reading import check_regular, format_validation_error
from physagent_jax.core.recent import Recent
from physagent_jax.forces.calibration import FRICTION
from physagent_jax.forces.part import Part, split_name
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.holds import Hold, HoldOrigin, find_blow
from physagent_jax.motion.landing import LIMP
from physagent_jax.motion.schema import AnchorRequest, MotionKind, WorldRequest
from physagent_jax.run.brief import make_brief
from physagent_jax.run.coloured import find_coloured_words
from physagent_jax.run.holding import UP, check_hold, find_hold
from physagent_jax.run.material import find_matter, resolve_material
from physagent_jax.run.models import warn_of_licences
from physagent_jax.run.photo import make_photo
from physagent_jax.run.postures import strip_postures
from physagent_jax.run.prompt import read_mask
from physagent_jax.run.provenance import hash_settings
from physagent_jax.run.rigidity import (
    RIGID_NOTE,
    STIFF_NOTE,
    TURNED_NOTE,
    is_hard,
    is_stiffened,
    is_turned_over,
    keeps_shape,
    make_rigid,
)
from physagent_jax.run.sentence_material import SaidMaterial, choose_said_material
from physagent_jax.run.sides import put_sides_first
from physagent_jax.run.spec import AnchorChoice, CameraChoice, RunSpec
from physagent_jax.run.unknown_parts import UnknownPartError
from physagent_jax.run.up_axis import UPRIGHT, explain_up, find_up
from physagent_jax.scene.anchor import MASK_BYTES
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.broad_side import find_broad_side
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.card import ObjectCard, load_card
from physagent_jax.scene.config import Anchor, CameraConfig, Domain, Material, Photo, SignedAxis, Source
from physagent_jax.scene.config.material import MODEL_PARAMETERS
from physagent_jax.scene.config.photo import ELEVATION
from physagent_jax.scene.load import hash_file, is_photo
from physagent_jax.scene.part_view import find_part_motion, turn_to_parts
from physagent_jax.scene.parts import (
    Frame,
    find_aliases,
    find_coloured,
    find_places,
    guess_parts,
    list_wholes,
)
from physagent_jax.scene.presets import PRESETS, Preset
from physagent_jax.scene.priors import (
    PRIORS,
    choose_anchor,
    choose_damping,
    choose_damping_ratio,
    find_kind,
    guess_kind,
    list_nouns,
)
from physagent_jax.scene.standing import Support, explain_tilt, hold_upright, level, make_stand
from physagent_jax.scene.template import SceneTemplate
from physagent_jax.scene.world import WORLDS, Obstacle, World

LET_GO = SemanticReply(force_field=ForceField(), anchor=AnchorRequest(kind="none"))
"""A reply that asks for nothing but that the object be free."""
VIEW_NOTE = (
    "the camera stands at azimuth {:.0f}, where the part's motion is seen; left and right are told from where it stood "
    "before; `--azimuth` keeps it elsewhere"
)
_listed: Recent[tuple[Part, ...]] = Recent(4)
_PRESET_PARTS = ("domain", "filling", "timing", "transfer", "rendering")


@dataclasses.dataclass(frozen=True)
class ResolvedRun:
    """A run that is ready to begin.

    Attributes:
        spec: What was asked for.
        base_dir: Folder that its relative paths start from.
        template: All of the scene but the force field; its anchor is what the object's kind asks for.
        inputs: sha256 of what makes two runs the same.
        warnings: What the user should know before it begins.
    """

    spec: RunSpec
    base_dir: Path
    template: SceneTemplate
    inputs: dict[str, str]
    warnings: tuple[str, ...]

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that the run reads."""
        return tuple(self.spec.files(self.base_dir).values())

    @property
    def frames_fixed(self) -> bool:
        """Return whether the clip's length is the user's, whatever the sentence asks for."""
        return self.spec.overrides.frame_count is not None

    def list_parts(self, body: Body) -> tuple[Part, ...]:
        """The parts of the object, and the regions that the sentence names by their place.

        Args:
            body: The object at rest.
        """
        told = (self.spec.prompt or "", self.template.source.name, self.template.camera)
        return _listed.find(body, told, lambda: self._list_parts(body))

    def _list_parts(self, body: Body) -> tuple[Part, ...]:
        table = find_viewer_directions(self.template.camera)
        viewer = Frame(toward=np.asarray(table["toward"]), right=np.asarray(table["right"]))
        prompt, name = put_sides_first(strip_postures(self.spec.prompt or "")), self.template.source.name
        known = (*body.parts, *find_aliases(body.shape, body.parts, prompt, name, viewer.toward))
        named = {
            word for part in known if part.stands_for and " " in part.name for word in split_name(part.name)
        }
        named |= list_wholes(name, self.template.source.kind)
        words = [word for word in split_name(prompt) if word not in named]
        guessed = guess_parts(body.shape, known, words, viewer, body.shells, name, prompt, body.colours)
        known = (*known, *guessed)
        places = find_places(body.shape, known, words, name, viewer, body.shells)
        others = {*split_name(name), *list_nouns(self.template.source.kind)}
        others |= {word for part in (*known, *places) if part.name for word in split_name(part.name)}
        places = (
            *places,
            *find_coloured(body.shape, body.colours, find_coloured_words(prompt, others)),
        )
        told = (*guessed, *places)
        return (*known, *places, *find_aliases(body.shape, told, prompt, name, viewer.toward))

    def turn(self, body: Body, reply: SemanticReply) -> Body:
        """The object in the attitude in which the sentence has it begin: ``body`` itself where it tells none."""
        source, preset = self.with_reply(reply).source, self.template.preset
        if source == self.template.source:
            return body
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # they were heeded when it was loaded upright
            return make_body(source, preset.filling, preset.domain, self.base_dir)

    def place_for_agents(self, body: Body, reply: SemanticReply | None = None) -> SceneTemplate:
        """The scene as `place` has it but for the stiffness, which agents are not told.

        Args:
            body: The object at rest.
            reply: What the sentence says of the scene; None = it is not read yet.
        """
        template = self.template if reply is None else self.with_reply(reply)
        return hold_upright(template, body, self._choose_support(reply))[0]

    def place(self, body: Body, reply: SemanticReply | None = None) -> tuple[SceneTemplate, tuple[str, ...]]:
        """The scene in which the object stays as it was captured, and in words what had to be changed for that.

        An object that cannot stand is made stiffer, held at its feet, or relieved of weight that nobody needs.

        Args:
            body: The object at rest.
            reply: What the sentence says of the scene; None = before it is read, for those who read it.

        Raises:
            UserError: The reply is about a part that is not known, or what is held cannot make a motion that it plans.
        """
        if reply is None:
            return make_stand(self.template, body, self._choose_support(None))
        if reply.unknown_parts:
            brief = make_brief(self.template, parts=self.list_parts(body))
            raise UnknownPartError(
                reply.unknown_parts, brief, f"`physagent inspect {self.spec.object.path}` draws them"
            )
        template, told = self._apply(reply)
        before, template = template.camera, self._look_at_parts(template, body, reply)
        viewed = () if template.camera == before else (VIEW_NOTE.format(template.camera.azimuth_degrees),)
        options = self._choose_support(reply)
        template, support = hold_upright(template, body, options)
        hold = self.find_hold(reply, body)
        held = () if hold is None else check_hold(hold, template.anchor, body, reply, self.base_dir)
        said = self.find_material(reply).preset
        keeps = hold is None and keeps_shape(reply)
        matter = (self.spec.material, self.template.matter, said, reply)
        if keeps and ((hard := is_hard(*matter)) or is_turned_over(*matter)):
            template = make_rigid(template, reply.world.restitution)  # a softer stand-in's looks are not seen
            told = (RIGID_NOTE if hard else TURNED_NOTE,)
        standing, notes = make_stand(template, body, options)
        bearing = standing.bearing
        if keeps and bearing is not None and is_stiffened(self.spec.material, said, bearing):
            told = (*told, STIFF_NOTE.format(bearing.most))
            rigid = make_rigid(template, reply.world.restitution)
            standing, notes = make_stand(rigid, body, options)
        return standing, (*told, *held, *support, *notes, *viewed)

    def _choose_support(self, reply: SemanticReply | None) -> Support:
        """The freedom that the user and the sentence leave to `make_stand`."""
        said = None if reply is None else self.find_material(reply).preset
        matter = (self.spec.material, self.template.matter, said)
        hard = is_hard(*matter, reply) or reply is not None and is_turned_over(*matter, reply)
        return Support(
            keep_material=self.spec.material.says_stiffness,
            keep_weight=reply is not None and reply.world.gravity is not None,
            let_go="none" in (self.spec.anchor.kind, reply and reply.anchor.kind),
            struck=None if reply is None else find_blow(reply.plan, UP),
            rigid=hard and (reply is None or keeps_shape(reply)),
            lands=reply is not None
            and any(e.kind is MotionKind.FALL and (e.jiggles or e.rebounds) for e in reply.plan),
            flops=reply is not None
            and reply.force_field.default_drop
            and LIMP.search((self.spec.prompt or "").lower()) is not None,
        )

    def _look_at_parts(self, template: SceneTemplate, body: Body, reply: SemanticReply) -> SceneTemplate:
        """The template with a camera that sees the parts move, where the whole stays in its place."""
        asked = [each for each in reply.expectations if each.kind is not MotionKind.STILL]
        if not template.camera.turn or not asked or any(each.limb is None for each in asked):
            return template
        parts = self.list_parts(body)
        motions = [
            find_part_motion(
                parts[each.limb], body.shape, each.direction, turns=each.kind is MotionKind.ROTATE
            )
            for each in asked
            if each.limb is not None and each.direction is not None
        ]
        return dataclasses.replace(template, camera=turn_to_parts(template.camera, body.shape, motions))

    def find_material(self, reply: SemanticReply) -> SaidMaterial:
        """The material that the sentence chooses, given its ``reply``."""
        if not reply.materials:
            return SaidMaterial()
        brief = make_brief(self.template, frames_fixed=self.frames_fixed)
        return choose_said_material(self.spec.prompt, brief, self.spec.material, reply.materials)

    def find_hold(self, reply: SemanticReply, body: Body) -> Hold | None:
        """The hold of the object, given the sentence's ``reply``; None if nothing holds it."""
        hold = find_hold(self.spec.anchor, self.template.source.kind, reply.anchor)
        place = "none" if hold is not None else self.place_for_agents(body, reply).anchor.kind
        return hold if place == "none" else Hold(place, HoldOrigin.SUPPORT)

    def with_reply(self, reply: SemanticReply) -> SceneTemplate:
        """The template with what the sentence says about material, holding, the world and the clip's length."""
        return self._apply(reply)[0]

    def _apply(self, reply: SemanticReply) -> tuple[SceneTemplate, tuple[str, ...]]:
        """As `with_reply`, and what the user should know of the sentence's material."""
        template, preset = self.template, self.template.preset
        if reply.frame_count is not None and not self.frames_fixed:
            timing = preset.timing.model_copy(update=dict(frame_count=reply.frame_count))
            preset = dataclasses.replace(preset, timing=timing)
        source = template.source
        if reply.world.attitude is not None:
            source = source.model_copy(update=dict(attitude=reply.world.attitude))
        template = dataclasses.replace(
            template,
            preset=preset,
            source=source,
            anchor=resolve_anchor(
                self.spec.anchor, template.source.kind, reply.anchor, base_dir=self.base_dir
            ),
            world=resolve_world(template.world, reply.world),
        )
        said = self.find_material(reply)
        return (template, ()) if said.preset is None else self._make_of(said, template)

    def _make_of(self, said: SaidMaterial, template: SceneTemplate) -> tuple[SceneTemplate, tuple[str, ...]]:
        """The template of another material."""
        kind = said.preset if said.preset in PRIORS else None
        material, notes = resolve_material(
            self.spec.material,
            template.matter,
            template.preset,
            base_dir=self.base_dir,
            said=said.preset,
        )
        reason = f"'{said.phrase}' in the sentence: {material.reason}"
        ratio = _choose_damping_ratio(self.spec, kind, template.preset, material) if kind else 0.0
        template = dataclasses.replace(
            template, material=material.changed(reason=reason), damping_ratio=ratio, damping_kind=kind
        )
        return template, notes


def resolve(
    spec: RunSpec,
    base_dir: str | Path = ".",
    *,
    origin: str = "the run's spec",
    source: Source | None = None,
) -> ResolvedRun:
    """Read what ``spec`` names and fill in what it leaves open.

    Args:
        spec: The run.
        base_dir: Folder that its relative paths start from.
        origin: Where the spec is from, for messages.
        source: Its object, where that has been loaded already; None = as the spec says.

    Raises:
        UserError: A file is missing or not what it should be, a name is not known, a value is out of range.
    """
    base_dir = Path(base_dir).resolve()
    path = base_dir / spec.object.path
    sha256 = hash_file(path)
    if spec.anchor.mask_path is not None:
        check_regular(base_dir / spec.anchor.mask_path, most=MASK_BYTES, what="the anchor mask")
    card = load_card(path)
    photo = None if source is not None else make_photo(spec, path, sha256, base_dir)
    known = spec.object if source is None else spec.object.model_copy(update=dict(up=source.up))
    up = UPRIGHT if is_photo(path) else find_up(known, card, base_dir)
    try:
        preset = resolve_preset(spec)
        found = source or _make_source(spec, card, path, sha256, up.axis, photo)
        anchor = resolve_anchor(spec.anchor, found.kind, base_dir=base_dir)
        if source is None:  # a photo is seen from its own camera, with which it would be turned
            source = found if photo is not None else level(found, preset.domain, anchor, WORLDS[spec.world])
        matter = find_matter(source, spec.prompt)
        material, warnings = resolve_material(spec.material, matter, preset, base_dir=base_dir)
        template = SceneTemplate(
            prompt=spec.prompt,
            preset_name=spec.preset.value,
            preset=preset,
            source=source,
            material=material,
            anchor=anchor,
            camera=_make_camera(spec.camera, card, source, preset.domain),
            world=WORLDS[spec.world],
            friction=_choose_friction(spec),
            damping_rate=choose_damping(source.kind),
            damping_ratio=_choose_damping_ratio(spec, matter, preset, material),
            damping_kind=None if matter == source.kind else matter,
            ledger=spec.ledger,
        )
    except ValidationError as error:
        raise format_validation_error(
            error, origin, do="`physagent schema scene` prints the ranges"
        ) from None
    warnings += explain_tilt(source)
    warnings += explain_up(up)
    warnings += warn_of_licences(spec.perception)
    if spec.perception.prompt is not None:
        rendering, timing = template.preset.rendering, template.preset.timing
        read_mask(spec.perception.prompt, rendering.width, rendering.height, timing.frame_count, base_dir)
    inputs = {what: hash_file(file) for what, file in spec.files(base_dir).items()}
    inputs["settings"] = hash_settings([spec.identity(), _describe_identity(template)])
    return ResolvedRun(spec, base_dir, template, inputs, warnings)


def resolve_preset(spec: RunSpec) -> Preset:
    """The preset with the spec's overrides and seed.

    Raises:
        pydantic.ValidationError: A value is out of range.
    """
    preset, changed = PRESETS[spec.preset], spec.overrides
    changes = {
        "domain": {"cells": changed.cells},
        "timing": {"frame_count": changed.frame_count},
        "filling": {"max_particles": changed.max_particles, "seed": spec.seed},
        "rendering": {"width": changed.width, "height": changed.height},
    }
    parts = {}
    for part, values in changes.items():
        given = {key: value for key, value in values.items() if value is not None}
        old = getattr(preset, part)
        parts[part] = type(old).model_validate({**old.model_dump(), **given})
    return dataclasses.replace(preset, **parts)


def resolve_anchor(
    choice: AnchorChoice, kind: str, said: AnchorRequest | None = None, *, base_dir: str | Path = "."
) -> Anchor:
    """Resolve the anchor: which particles are held.

    Args:
        choice: Choice of the spec.
        kind: The object's.
        said: What the sentence says about holding, which "auto" goes by; None = it has not been read.
        base_dir: Folder that a relative path starts from.
    """
    reason = "chosen for the run"
    match choice.kind:
        case "auto":
            said = said or AnchorRequest()
            if said.kind == "rest":
                return Anchor(kind="region", region=said.region, reason=f"{said.words} alone is to move")
            return choose_anchor(kind, said.kind, said.words)
        case "box":
            return Anchor(kind="box", point=choice.point, half_size=choice.half_size, reason=reason)
        case "mask":
            assert choice.mask_path is not None  # as the spec has checked
            return Anchor(
                kind="mask", mask_path=str((Path(base_dir) / choice.mask_path).resolve()), reason=reason
            )
    return choose_anchor(kind, choice.kind).model_copy(update=dict(reason=reason))


def resolve_world(world: World, said: WorldRequest) -> World:
    """``world`` with what the sentence says about it, which goes first.

    Without gravity nothing stands anywhere: unless the sentence names a ground, there is then none.
    """
    gravity = said.gravity or world.gravity
    ground = said.ground
    if ground is None:
        ground = gravity == "down" if said.gravity is not None else world.ground
    obstacles = tuple(Obstacle(each.kind, each.direction, each.distance) for each in said.obstacles)
    height = world.drop_height if said.drop_height is None else said.drop_height
    return dataclasses.replace(world, gravity=gravity, ground=ground, obstacles=obstacles, drop_height=height)


def _choose_damping_ratio(spec: RunSpec, kind: str, preset: Preset, material: Material) -> float:
    """That of the kind, for its own matter in a preset that has no drag of its own."""
    named = spec.material.name is not None or spec.material.physgm is not None
    takes = "damping_ratio" in MODEL_PARAMETERS[material.model]
    return choose_damping_ratio(kind) if takes and not named and not preset.transfer.damping_rate else 0.0


def _choose_friction(spec: RunSpec) -> float:
    if spec.friction is not None:
        return spec.friction
    return FRICTION if spec.world == "ground" else 0.0


def _make_source(
    spec: RunSpec, card: ObjectCard, path: Path, sha256: str, up: SignedAxis, photo: Photo | None
) -> Source:
    name = card.name or path.stem.replace("_", " ")
    kind = card.kind or guess_kind(name, spec.prompt or "")
    if spec.object.kind is not None:
        kind = find_kind(spec.object.kind, "`object.kind`")
    return Source(
        path=str(path.resolve()),
        sha256=sha256,
        name=name,
        kind=kind,
        up=up,
        opacity_threshold=spec.object.opacity_threshold,
        splat_encoding=spec.object.splat_encoding,
        extent=spec.object.extent,
        parts=spec.object.parts,
        photo=photo,
    )


def _make_camera(choice: CameraChoice, card: ObjectCard, source: Source, domain: Domain) -> CameraConfig:
    pictured = source.photo is not None
    given = [each for each in (choice.azimuth_degrees, card.azimuth_degrees) if each is not None]
    azimuth = given[0] if given else 0.0 if pictured else find_broad_side(source, domain)
    stated = (choice.elevation_degrees, source.photo and source.photo.elevation_degrees, ELEVATION)
    return CameraConfig(
        azimuth_degrees=azimuth,
        elevation_degrees=next(each for each in stated if each is not None),
        follow=choice.follow,
        turn=choice.azimuth_degrees is None and not pictured,
    )


def _describe_identity(template: SceneTemplate) -> dict:
    """The values behind names and defaults: a later version, or another card, may use other ones."""
    places: Any = {"path": True, "photo": {"mask_path", "depth_path"}}
    return {
        "preset": {name: getattr(template.preset, name).model_dump(mode="json") for name in _PRESET_PARTS},
        "source": template.source.model_dump(mode="json", exclude=places),
        "material": template.material.model_dump(mode="json"),
        "camera": template.camera.model_dump(mode="json"),
        "anchor": template.anchor.model_dump(mode="json", exclude={"mask_path"}),
        "damping_rate": template.damping_rate,
        "damping_ratio": template.damping_ratio,
        "friction": template.friction,
    }
