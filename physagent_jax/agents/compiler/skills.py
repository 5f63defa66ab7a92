"""Events in their windows -> actions of the skill library and what a viewer should see: one function per `Effect`."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.compiler.blows import (
    compile_fall,
    compile_jump,
    compile_strike,
    compile_topple,
    leap,
    spin_aloft,
)
from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.directions import has_wheels
from physagent_jax.agents.compiler.events import WayKind
from physagent_jax.agents.compiler.schedule import Slot
from physagent_jax.agents.compiler.steady import Task, add_steady
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.forces.calibration import DROP_HEIGHT, MAGNITUDE_MAX, QUICK, SWING, TURN
from physagent_jax.forces.schema import ActionType, ConstraintType
from physagent_jax.forces.skills import find_skill
from physagent_jax.forces.slabs import make_end_region
from physagent_jax.motion.attitudes import stand_on_edge
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.breaking import burst, find_break
from physagent_jax.motion.efforts import find_lengths, find_strain_magnitude, find_swing_magnitude
from physagent_jax.motion.limbs import sum_directions
from physagent_jax.motion.pressing import find_end_of_poke, quiver, shake_itself
from physagent_jax.motion.schema import Amount, MotionKind
from physagent_jax.motion.swaying import bend, find_bend, fold, leads_aside, lies, rock, shake, sway, walk
from physagent_jax.motion.vectors import dot, normalise, reject, scale
from physagent_jax.motion.windows import Window, divide, divide_swings, make_impulse_window, shorten

_SLOW = ("slow", "gradual", "lazi")  # begins of words for the pace alone
_UPRIGHT = 0.7  # cosine
_GROUNDED = 115.0  # [degrees] that the top turns by of what is bent to the ground over its foot
_LEAN = 0.5  # torque of a lean relative to a full turn


def compile_slots(slots: list[Slot], builder: ForceFieldBuilder) -> None:
    """Compiles every event; each knows what comes after it."""
    for index, slot in enumerate(slots):
        following = slots[index + 1 : index + 2]
        builder.room = following[0].window[1] if following else builder.brief.last
        stops = [each for each in slot.events if each.effect is Effect.STILL]
        moving = [each for each in slot.events if each.effect not in (Effect.STILL, Effect.RELEASE)]
        if stops and not all(each.limbs for each in moving):  # the rest of what moves its limbs is held
            doubt = f"What '{stops[0].text}' keeps still while the rest moves is not understood."
            builder.unsure.append(doubt)
        for event in slot.events:
            builder.notes += event.notes
            builder.unsure += event.doubts
            builder.obstacles += [each for each in event.obstacles if each not in builder.obstacles]
            after = [event for later in following for event in later.events]
            first, end = slot.window
            if event.is_quick and (event.motion.quick or not builder.anchored):
                end = min(end, first + QUICK / builder.brief.frame_dt)
            task = Task(event, (first, end), after, builder)
            made = len(builder.actions), len(builder.constraints)
            if event.motion.skill is not None and not event.repeat.alternate:
                _compile_by_skill(task, event.motion.skill)
            elif not (event.bursts and event.motion.gives and builder.earlier):
                _COMPILERS[event.effect](task)
            if event.bursts:
                _compile_break(task)
            if event.is_nudged:
                _show_hand(builder, *made)
        builder.earlier += [event.effect for event in slot.events]


def _show_hand(builder: ForceFieldBuilder, actions: int, constraints: int) -> None:
    """Let people see the hand that makes the first of an event's new strokes, unless a plate is seen to."""
    new = builder.constraints[constraints:]
    if any(each.constraint_type is ConstraintType.MOVING_PLATE for each in new):
        return
    if new:
        builder.constraints[constraints] = new[0].model_copy(update=dict(touched=True))
    elif len(builder.actions) > actions:
        builder.actions[actions] = builder.actions[actions].model_copy(update=dict(touched=True))


def _compile_push(task: Task) -> None:
    event, builder, (first, last) = task.event, task.builder, task.window
    if event.repeat.alternate:
        _compile_sway(task)
    elif event.motion.steps and builder.grounded and not (builder.anchored or event.region) and last > first:
        count = task.limit_count(event.repeat.count or event.motion.cycles)
        lengths = find_lengths(event.amount, task.brief)
        builder.constraints += walk(task.brief, task.direction, event.strength, count, task.window, lengths)
        task.expect(MotionKind.MOVE, task.direction, task.window, leaves_place=True)
    else:
        _compile_by_skill(task, ActionType.TRANSLATION.value)


def _compile_by_skill(task: Task, name: str) -> None:
    """A skill, as often as it is told, with pauses; the first motion that it causes is expected."""
    event, skill, kind = task.event, find_skill(name), ActionType(name)
    acted, count = task.window, task.limit_count(event.count)
    strength = event.strength * (event.motion.sign if skill.is_two_sided else 1)
    if count == 1 and not skill.is_sudden:
        acted = add_steady(task, kind, task.direction, strength)
    else:
        for part in divide(task.window, [1.0] * (2 * count))[::2]:
            part = make_impulse_window(part[0]) if skill.is_sudden else part
            task.act(kind, task.direction, strength, part)
    sways = task.builder.anchored and count > 1 and MotionKind.SWAY in skill.causes
    task.expect(
        MotionKind.SWAY if sways else MotionKind(skill.causes[0]),
        event.direction,
        acted,
        repeats=count,
        sudden=skill.is_sudden or event.motion.quick and bool(event.limbs),
        released=task.is_released,
        leaves_place=count == 1 and event.motion.skill is None and task.leaves_place,
    )


def _compile_sway(task: Task) -> None:
    """To and fro; what bobs on the ground is thrown up each time, and weight brings it back."""
    first, begin = task.window[0], find_end_of_poke(task.builder.constraints, task.window)
    hit, task = begin > first, replace(task, window=(begin, task.window[1]))
    event, builder, brief, up = task.event, task.builder, task.brief, task.brief.directions.up
    count, held = task.limit_count(event.repeat.count or event.motion.cycles), builder.anchored
    magnitude, leads = event.strength, builder.rooted and leads_aside(task.direction, brief)
    # A plant bends by itself.
    lasts = task.window[1] > task.window[0]  # not in a clip of one frame
    free = builder.grounded and not held and lasts and not _travels(task)
    bends = event.motion.manner in ("bend", "rock") and "feet" in (brief.anchored or "feet")
    if event.amount is not None:
        magnitude = find_swing_magnitude(event.amount, held, brief) or magnitude
    seen = builder.expectations
    if hit and seen and seen[-1].kind is MotionKind.MOVE:
        seen.pop()  # what is poked goes along as it wobbles, by more than a finger's depth
        begin = first
    fell = (
        builder.soft
        and builder.earlier[-1:] == [Effect.TOPPLE]
        and (event.motion.jiggles or event.motion.wobbles)
    )
    if fell and lasts and not (held or event.ways or event.repeat.count or event.limbs or event.region):
        begin = max((each.active_time[1] for each in builder.constraints if each.active_time), default=begin)
        builder.constraints += shake_itself(brief, task.direction, magnitude, (begin, task.window[1]), True)
    elif hit and not (held or event.repeat.count or event.limbs or event.region):
        builder.constraints += quiver(brief, task.direction, 2 * magnitude, task.window)
    elif builder.grounded and not held and abs(dot(task.direction, up)) > _UPRIGHT:
        for part in divide(task.window, [1.0] * count):
            task.act(ActionType.IMPULSE, up, 2 * SWING * magnitude, make_impulse_window(part[0]))
    elif event.motion.manner in ("rock", brief.may_be_held and "bend") and free and not event.limbs:
        builder.constraints += rock(brief, task.direction, magnitude, count, task.window)
    elif event.motion.manner == "shake" and free and not (event.amount or event.region):
        raised = task.is_raised
        builder.constraints += shake(brief, task.direction, magnitude, count, task.window, raised)
    elif leads and lasts and (brief.anchored and count > 3 or bends) and not event.limbs:
        builder.constraints += sway(brief, task.direction, magnitude, count, task.window)
    else:
        _alternate(task, ActionType.TRANSLATION, magnitude, divide_swings(task.window, count, held))
    told = dict(repeats=count, released=task.is_released) | (dict(manner="", jiggles=True) if fell else {})
    task.expect(MotionKind.SWAY, event.direction, (begin, task.window[1]), **told)


def _travels(task: Task) -> bool:
    """Return whether all of it goes somewhere meanwhile: led to and fro, it would stay: "slides away, fluttering"."""
    first = round(task.window[0])  # as what is expected has it
    moves = [e for e in task.builder.expectations if e.kind is MotionKind.MOVE and not e.partial]
    return any(each.window[0] <= first < each.window[1] for each in moves)


def _alternate(task: Task, kind: ActionType, magnitude: float, windows: list[Window]) -> None:
    """Adds an action in each window, each against the one before."""
    for index, window in enumerate(windows):
        task.act(kind, scale(task.direction, -1.0 if index % 2 else 1.0), magnitude, window)


def _compile_lean(task: Task) -> None:
    """Parts, anchored things and things in the wind are pushed over; a free thing is turned."""
    event, brief = task.event, task.brief
    paces = event.clause.strength
    if paces and all(each.lower().startswith(_SLOW) for each in paces):  # as far as else, in more time
        event = replace(event, strength=max(event.strength, event.motion.strength))
    if event.motion.manner == "fold" and (event.region or event.limbs or brief.anchored):
        event = replace(
            event, motion=replace(event.motion, manner="bend")
        )  # a part goes over, or what is rooted
    bends = event.motion.manner == "bend" and not (event.region or event.is_in_wind)
    if bends and not event.limbs and any(way.phrase in read_lexicon().grounding for way in event.ways):
        across, told = reject(task.direction, brief.directions.up), event.amount
        amount = told if told and told.unit != "degrees" else Amount(value=_GROUNDED, unit="degrees")
        event = replace(event, direction=normalise(across) or brief.directions.left, amount=amount)
    task = replace(task, event=event)
    vertical = abs(dot(task.direction, brief.directions.up)) >= 0.9
    way, lying, let_go = find_bend(task.direction, brief, task.builder.rooted), lies(brief), task.is_released
    lasts = task.window[1] > task.window[0]  # not in a clip of one frame
    limbs = [brief.parts[limb] for limb in event.limbs]
    loose = all(limb.seated and "head" not in limb.roles[:1] for limb in limbs)
    joined = bool(limbs) and not (loose and event.motion.manner == "rock")  # a lid tilts about its own middle
    if event.repeat.alternate or event.count > 1:
        _compile_sway(task)
    elif event.motion.manner == "fold" and lasts:
        turns, way = fold(brief, task.window)
        task.builder.constraints += turns
        end = dict(part=scale(way, -1.0), partial=True, strength=MAGNITUDE_MAX)
        task.expect(MotionKind.MOVE, way, task.window, **end)
    elif bends and way and lasts:
        task.builder.constraints += bend(brief, way, event.strength, event.amount, task.window, let_go)
        end = dict(part=brief.long_axis if lying else event.part, partial=lying)
        task.expect(MotionKind.MOVE, way, task.window, released=let_go, **end)
    elif task.builder.anchored or joined or event.is_in_wind or vertical or brief.object_kind == "plant":
        _compile_push(task)
    else:
        axis, strength = find_lean_axis(task.direction, brief), _LEAN * event.strength
        acted = add_steady(task, ActionType.TORQUE, axis, strength)
        task.expect(MotionKind.ROTATE, axis, acted, strength=strength, released=task.is_released)


def _compile_scale(task: Task) -> None:
    """Along one axis, or along all three (`Effect.SWELL`); several times with pauses if counted."""
    event, builder, window = task.event, task.builder, task.window
    table = builder.brief.directions
    axes = [table.right, table.up, table.toward] if event.direction is None else [event.direction]
    usual = 2 if event.repeat.alternate else event.motion.strokes
    count = task.limit_count(event.repeat.count or usual)
    windows = divide(window, [1.0] * (2 * count))[::2] if count > 1 else [window]
    strength = event.strength
    if event.amount is not None and event.amount.unit == "factor":
        strength = find_strain_magnitude(event.amount)
        task = replace(task, event=replace(event, stays=event.stays or count == 1 and task.is_kept))
        if strength > MAGNITUDE_MAX:
            builder.notes.append(f"'{event.text}': more than the strongest force is calibrated for.")
    for part in windows:
        for axis in () if event.motion.gives else axes:
            task.act(ActionType.SCALE, axis, event.motion.sign * strength, part)
    kind = MotionKind.STRETCH if event.motion.sign > 0 else MotionKind.SQUEEZE
    told = dict(repeats=count, released=count > 1 or task.is_released, sudden=event.motion.quick)
    task.expect(kind, event.direction, windows[0], **told)


def _compile_burst(task: Task) -> None:
    """Outward along all axes, briefly: a uniform impulse has no outward form."""
    task.builder.notes.append("An explosion without a direction is a brief stretch in all directions.")
    _compile_scale(replace(task, window=shorten(task.window, task.builder.brief.last)))


def _compile_break(task: Task) -> None:
    """The burst of what breaks, as it lands or by itself."""
    builder, event = task.builder, task.event
    drops = builder.default_drop and event.effect is Effect.FALL and not builder.earlier
    drop = (builder.drop_height or DROP_HEIGHT) if drops else None
    at = find_break(task.window, task.brief, builder.actions, builder.constraints, drop)
    builder.constraints.append(burst(at, builder.bursts * event.strength, task.brief))


def _compile_turn(task: Task) -> None:
    event, free = task.event, not task.builder.anchored
    if event.repeat.alternate:
        count = task.limit_count(event.repeat.count or 2)
        shares = [0.5, *[1.0] * (2 * count - 1), 0.5] if free else [1.0] * (2 * count)
        windows = divide(task.window, shares)
        _alternate(task, ActionType.TORQUE, event.strength, windows)
        seen = task.window if event.limbs else windows[0]
        task.expect(MotionKind.ROTATE, event.direction, seen, repeats=count)
    elif event.motion.wrings and event.part is None:  # at its waist: one half against the other
        _compile_twist(replace(task, event=replace(event, region=None)))
    else:
        _turn_steadily(task)


def _turn_steadily(task: Task) -> None:
    motion, builder = task.event.motion, task.builder
    whole = not (task.event.limbs or task.event.region)
    if motion.leaps and whole and builder.grounded and not builder.anchored and not builder.earlier:
        jump, told = read_lexicon().motions["jump"], task.event.pick(WayKind.TO)
        # "Backwards" is how it turns.
        names = told[0].names if told and told[0].names != ("away",) else ("up",)
        way = normalise(sum_directions(names, task.brief))
        leap(replace(task, event=replace(task.event, motion=jump, direction=way, amount=None)))
    if spin_aloft(task, task.direction):
        return
    acted = add_steady(task, ActionType.TORQUE, task.direction, task.event.strength)
    task.expect(MotionKind.ROTATE, task.direction, acted, released=task.is_released)


def _compile_twist(task: Task) -> None:
    """One end against the other, half each; the free end alone where the other is held.

    An object both of whose ends turn stays where it is as a whole, and nothing has to be braked.
    """
    builder, axis, amount, up = task.builder, task.direction, task.event.amount, task.brief.directions.up
    event = replace(task.event, stays=task.event.stays or task.is_kept)
    if builder.anchored:
        end = task.brief.directions.down if "top" in (task.brief.anchored or "") else up
        axis, there = axis if event.ways else up, make_end_region(end, 0.5)
        return _turn_steadily(replace(task, event=replace(event, part=end, region=there, direction=axis)))
    builder.notes.append(f"'{event.text}': one end turns against the other.")
    if amount is not None and amount.unit == "degrees":
        event.amount = amount.model_copy(update={"value": amount.value / 2})
    for sign in (1.0, -1.0):
        end, way = scale(up if abs(dot(axis, up)) > _UPRIGHT else axis, sign), scale(axis, sign)
        half = replace(event, part=end, region=make_end_region(end, 0.5), direction=way)
        turned = replace(task, event=half)
        turned.act(ActionType.TORQUE, way, half.strength, task.window)
        turned.expect(MotionKind.ROTATE, way, task.window, released=turned.is_released)


def _compile_roll(task: Task) -> None:
    """Travels along the direction while the top turns into it: what has fallen over, by as much as it goes."""
    event, axis, brief = task.event, find_lean_axis(task.direction, task.brief), task.brief
    edge = None if task.builder.earlier or has_wheels(brief) else stand_on_edge(task.direction, brief)
    if edge is not None and task.builder.grounded and task.builder.attitude is None:
        task.builder.attitude = edge
        task.builder.notes.append(f"'{event.text}': it lies flat, so it begins on its edge.")
    acted = add_steady(task, ActionType.TRANSLATION, task.direction, event.strength)
    girth = TURN * 0.25 * (brief.extents[0] + brief.extents[2]) / brief.size
    add_steady(task, ActionType.TORQUE, axis, event.strength / (girth if task.rolls_on else 1.0))
    turns = event.amount is not None and event.amount.unit == "degrees"
    task.expect(MotionKind.MOVE, event.direction, acted, amount=None if turns else event.amount)
    task.expect(MotionKind.ROTATE, axis, acted, amount=event.amount if turns else None)


def _compile_stillness(task: Task) -> None:
    """Nothing moves; a part that moves meanwhile is another one than the word means."""
    seen = task.builder.expectations
    moving = {e.limb for e in seen if e.kind is not MotionKind.STILL and e.window[1] > task.window[0] + 0.5}
    if moving.isdisjoint(task.event.limbs):
        lasts = bool(seen) and not task.after and task.event.when.lasts is not None
        task.expect(MotionKind.STILL, None, task.window, stays=lasts)
    else:
        note = f"'{task.event.text}': that part moves meanwhile, so it is not asked to be still."
        task.builder.notes.append(note)


_COMPILERS = {
    Effect.PUSH: _compile_push,
    Effect.LEAN: _compile_lean,
    Effect.SWAY: _compile_sway,
    Effect.SCALE: _compile_scale,
    Effect.SWELL: _compile_scale,
    Effect.STRIKE: compile_strike,
    Effect.BURST: _compile_burst,
    Effect.TURN: _compile_turn,
    Effect.ROLL: _compile_roll,
    Effect.FALL: compile_fall,
    Effect.TOPPLE: compile_topple,
    Effect.JUMP: compile_jump,
    Effect.STILL: _compile_stillness,
    Effect.RELEASE: lambda task: None,  # release and holding act through windows of others and the anchor
    Effect.HOLD: lambda task: None,
}
