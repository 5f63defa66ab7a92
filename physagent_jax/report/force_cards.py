"""A force field as cards that a person can read."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from physagent_jax.forces.binding import Stroke
from physagent_jax.forces.calibration import GRAVITY, MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.responses import scale_entry
from physagent_jax.forces.schema import Action, ForceField, SkillScaling, VelocityConstraint
from physagent_jax.forces.skills import get_skill
from physagent_jax.forces.swinging import find_strokes
from physagent_jax.motion.schema import DirectionTable
from physagent_jax.report.directions import (
    describe_axis,
    describe_direction,
    describe_turn,
    make_direction_table,
)
from physagent_jax.report.force_terms import describe_force_term, describe_region
from physagent_jax.report.formats import format_fixed, format_number, format_vector, format_window, spell_out
from physagent_jax.report.icons import draw_skill_icon
from physagent_jax.report.layout import make_json_fold
from physagent_jax.report.markup import Markup, div, span, tag
from physagent_jax.scene.config import CameraConfig, ForceTerm, SceneConfig

Timed = Action | VelocityConstraint


@dataclasses.dataclass(frozen=True)
class Setting:
    """The facts about a scene that a card needs.

    Attributes:
        directions: The viewer's directions.
        last_frame: Last frame of the clip; None if unknown.
        frame_dt: Seconds per frame [s]; None if unknown.
        scaling: What a magnitude of 1 means; None if not recorded.
        always_gravity: Gravity acts whatever the force field says.
        terms: What else acts, besides the force field.
    """

    directions: DirectionTable
    last_frame: int | None = None
    frame_dt: float | None = None
    scaling: SkillScaling | None = None
    always_gravity: bool = False
    terms: tuple[ForceTerm, ...] = ()


def read_setting(scene: SceneConfig | None) -> Setting:
    """The setting of a scene; the reference camera's defaults if the scene is not known."""
    if scene is None:
        return Setting(make_direction_table(CameraConfig()))
    timing = scene.timing
    return Setting(
        make_direction_table(scene.camera),
        timing.frame_count - 1,
        timing.frame_dt,
        scene.scaling,
        scene.always_gravity,
        scene.forces,
    )


def make_force_cards(
    force_field: ForceField, setting: Setting, *, previous: ForceField | None = None, name: str = ""
) -> Markup:
    """Cards of all actions and constraints, the scene's own terms, gravity, and the JSON behind a fold.

    Args:
        force_field: What to show.
        setting: About the scene.
        previous: The force field before it, to mark what changed.
        name: Prefix of the cards' ids ("{name}-actions-0").
    """
    cards, strokes = [], _find_strokes(force_field, setting)
    for kind in ("actions", "constraints"):
        before = getattr(previous, kind) if previous else ()
        for index, item in enumerate(getattr(force_field, kind)):
            old = (
                before[index]
                if index < len(before) and _name_kind(before[index]) == _name_kind(item)
                else None
            )
            stroke = strokes.get(index) if kind == "actions" else None
            cards.append(
                _make_card(item, setting, old, stroke, id_=f"{name}-{kind}-{index}" if name else None)
            )
    if not cards:
        nothing = "No force acts on the object." if not setting.terms else "The force field is empty."
        cards.append(div("card force quiet", nothing))
    return div(
        "forces",
        div("cards", *cards),
        _make_term_list(setting),
        _describe_gravity(force_field, setting),
        make_json_fold("Force field as JSON", force_field),
    )


def _find_strokes(force_field: ForceField, setting: Setting) -> dict[int, Stroke]:
    """The velocity changes of pushes to and fro, as far as the scene is known."""
    if setting.scaling is None or setting.frame_dt is None or setting.last_frame is None:
        return {}
    values = ForceFieldParameters.of(force_field, setting.last_frame + 1).actions
    return find_strokes(force_field, values, setting.scaling, setting.frame_dt)


def _name_kind(item: Timed) -> str:
    return get_skill(item).name


def describe_effect(item: Timed, table: DirectionTable) -> str:
    """Describe an item's effect in the viewer's words, with the sign of its magnitude."""
    skill, reverse = get_skill(item), item.magnitude < 0
    pointing = tuple(-component if reverse else component for component in item.vector)
    words = skill.reverse_effect if reverse and skill.reverse_effect else skill.effect
    return words.format(
        direction=describe_direction(pointing, table),
        turn=describe_turn(pointing, table),
        axis=describe_axis(item.vector, table),
    )


def _make_card(
    item: Timed,
    setting: Setting,
    old: Timed | None,
    stroke: Stroke | None,
    id_: str | None,
) -> Markup:
    skill = get_skill(item)
    head = div(
        "force-head",
        draw_skill_icon(skill, item.vector, setting.directions, reverse=item.magnitude < 0),
        div(
            "",
            tag("strong", spell_out(skill.name).capitalize()),
            tag("p", describe_effect(item, setting.directions)),
        ),
    )
    rows = [
        ("axis" if skill.is_axis else "direction", _show_direction(item, old)),
        ("magnitude", _show_magnitude(item, old, setting, stroke)),
        ("active", _show_window(item, old, setting)),
        ("acts on", [describe_region(item.region), f" of {item.object}" if item.object else None]),
    ]
    return div("card force", head, tag("dl", *[(tag("dt", k), tag("dd", v)) for k, v in rows]), id=id_)


def _show_direction(item: Timed, old: Timed | None) -> list:
    return [span("mono", format_vector(item.vector)), _show_previous(old, item, "vector", format_vector)]


def _show_magnitude(item: Timed, old: Timed | None, setting: Setting, stroke: Stroke | None) -> list:
    ghost = None
    if old is not None and old.magnitude != item.magnitude:
        ghost = tag("i", class_="ghost", style=f"left:{_place_magnitude(old.magnitude):.1f}%")
    bar = div(
        "bar",
        tag("i", class_="fill", style=f"width:{_place_magnitude(item.magnitude):.1f}%"),
        tag("i", class_="one", style=f"left:{_place_magnitude(1.0):.1f}%"),
        ghost,
        title=f"from {MAGNITUDE_MIN} (slight) over 1 (plain) to {MAGNITUDE_MAX} (violent)",
    )
    note = " reversed" if item.magnitude < 0 else ""
    return [
        span("number", format_fixed(item.magnitude)),
        span("quiet", note) if note else None,
        _show_previous(old, item, "magnitude", format_fixed),
        bar,
        _show_physical(item, setting, stroke),
    ]


def _show_physical(item: Timed, setting: Setting, stroke: Stroke | None) -> list[Markup] | None:
    """The magnitude in SI units, if the run recorded what 1 means, and the acceleration beside gravity."""
    scaling = setting.scaling
    if scaling is None:
        return None
    skill, swing = get_skill(item), float(stroke.k) if stroke is not None and stroke.swings else None
    one, meaning = skill.explain_one(scale_entry(scaling, item), item.vector, swing)
    one *= item.gain
    again = f", k calibrated again: x {format_number(item.gain)}" if item.gain != 1.0 else ""
    text = f"{format_number(abs(item.magnitude) * one)} {skill.unit} (1 means {format_number(one)}{again})"
    shown = [span("quiet", text, title=f"1 means {meaning}")]
    acceleration = find_acceleration(item, abs(item.magnitude) * one, setting)
    if acceleration is not None:
        blow = f"{format_number(acceleration)} m/s\u00b2 while it lasts, " if skill.unit == "m/s" else ""
        shown.append(span("acceleration", f"{blow}{format_number(acceleration / GRAVITY, 2)} times gravity"))
    return shown


def find_acceleration(item: Timed, value: float, setting: Setting) -> float | None:
    """The acceleration that an action gives to matter [m/s^2]; None where it sets velocities, or turns.

    Args:
        item: The action.
        value: Its strength in the unit of its skill.
        setting: For the time within which a blow is dealt.
    """
    if isinstance(item, VelocityConstraint):
        return None
    unit = get_skill(item).unit
    if unit == "m/s\u00b2":
        return value
    if unit != "m/s" or item.active_time is None or setting.frame_dt is None:
        return None
    first, last = item.active_time
    return value / ((last - first) * setting.frame_dt) if last > first else None


def _show_window(item: Timed, old: Timed | None, setting: Setting) -> list:
    strip = None
    if setting.last_frame:
        first, last = item.active_time or (0.0, float(setting.last_frame))
        left, right = (100 * min(1.0, value / setting.last_frame) for value in (first, last))
        strip = div("strip", tag("i", style=f"left:{left:.1f}%;width:{max(1.0, right - left):.1f}%"))
    hold_end = item.held_until if isinstance(item, VelocityConstraint) else None
    return [
        _describe_window(item.active_time, setting.frame_dt),
        span("quiet", f", then held until frame {format_number(hold_end)}") if hold_end is not None else None,
        _show_previous(old, item, "active_time", _describe_window),
        strip,
    ]


def _describe_window(active: tuple[float, float] | None, frame_dt: float | None = None) -> str:
    return "the whole clip" if active is None else format_window(*active, frame_dt)


def _show_previous(old: Timed | None, item: Timed, field: str, words: Callable[[Any], str]) -> Markup | None:
    """The value before, if it was another."""
    if old is None or getattr(old, field) == getattr(item, field):
        return None
    return span("was", f"was {words(getattr(old, field))}")


def _place_magnitude(magnitude: float) -> float:
    """The position of a magnitude on the bar [%]."""
    return 100 * min(1.0, max(0.0, (abs(magnitude) - MAGNITUDE_MIN) / (MAGNITUDE_MAX - MAGNITUDE_MIN)))


def _make_term_list(setting: Setting) -> Markup | None:
    """The scene's own terms."""
    if not setting.terms:
        return None
    items = [tag("li", describe_force_term(term, setting.directions)) for term in setting.terms]
    return tag("ul", items, class_="quiet")


def _describe_gravity(force_field: ForceField, setting: Setting) -> Markup:
    acts = force_field.default_drop or setting.always_gravity
    text = (
        "Gravity acts: the object has weight." if acts else "Gravity is off: the rest pose bears it already."
    )
    return tag("p", text, class_="quiet gravity")
