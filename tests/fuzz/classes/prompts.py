"""Sentences through the offline agents: read, judged against a made-up motion report, rewritten twice, compiled."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import SceneBrief
from tests.agents.scenes import IDENTITY, brief, judge, read, rewrite, seen_in, table
from tests.agents.sentences import SENTENCES
from tests.fuzz.contract import Breach, Case, Fault
from tests.fuzz.drawing import TEXTS, Draw

THINGS = (
    "it",
    "the robot",
    "the plant",
    "the red part",
    "the top",
    "its left half",
    "the upper third",
    "everything",
    "",
)
VERBS = (
    "push", "kick", "drop", "twist", "spin", "stretch", "squeeze", "squash", "bend", "sway", "shake",
    "lift", "throw up", "pull", "hit", "blow", "rotate", "bounce", "hold", "let go of", "tear apart",
    "hang", "tap", "nudge", "swing", "freeze",
)  # fmt: skip
HOW = (
    "gently", "hard", "very slowly", "twice", "three times", "a bit", "not", "suddenly",
    "as hard as possible", "like a whisper", "by 90 degrees", "2 meters", "with 5 N", "17 times",
    "a thousand times", "over and over", "with 1e999 force",
)  # fmt: skip
WHERE = (
    "to the left", "right", "up", "down", "towards us", "away", "backwards", "to the left and up",
    "sideways", "from below", "diagonally", "clockwise", "north", "along its height", "in all directions",
    "from left to right",
)  # fmt: skip
WHEN = (
    "", "for half a second", "from t = 0.5 s to t = 1.5 s", "after 1 s", "at the end", "for 1e9 seconds",
    "for -3 s", "for 0 s", "for 1e400 s", "halfway", "until it stops", "in frame 3",
    "during the second half", "for 99999999999999999999 minutes",
)  # fmt: skip
FLAT = ((3.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1e-9))
JOIN = (
    ", then ",
    " and ",
    "; ",
    ". ",
    " while ",
    " but ",
    ", ",
    " before ",
    " after ",
    "\n",
    " or ",
    " without ",
)
OTHER = (
    "schiebe den Roboter sanft nach links und lass ihn dann fallen", "pousse le robot vers la gauche",
    "把机器人推到左边", "ロボットを左に押す", "ادفع الروبوت إلى اليسار", "толкни робота влево",
    "PUSH IT LEFT!!!", "puuuush it to the leeeeft", "push it lfet", "push it to the left" + "!" * 500,
    "left " * 400, "and " * 300, "push it then " * 60, "<script>alert(1)</script> push it left",
    "push it {left} %s %d", "push\tit\u00a0to\u2003the\u200bleft", "p\u0301ush it left",
    "\ufeffpush it left", "push it left\0", "1e400", "9" * 6000, "push it " + "9" * 6000 + " times",
    "push it for " + "1" * 400 + " seconds", "½ push ¼ left ² times ③ up", "twist it by ٣٠ degrees",
    "wait " * 50 + "push it left", "(" * 500, "'" * 500, "a" * 20_000, "push " * 800,
)  # fmt: skip


def make(draw: Draw) -> Case:
    """One sentence in one scene."""
    prompt = draw.one(
        [_draw_sentence] * 4
        + [_draw_known, _draw_text, _draw_words, lambda d: d.one(OTHER), lambda d: d.one(OTHER)]
    )(draw)
    frames = draw.one([49, 49, 49, 2, 3, 5, 200])
    scene = brief(
        frame_count=frames,
        object_name=draw.one(["robot", "plant", "a b", "", "ü", "left", "push"]),
        anchored=draw.one([None, None, "rooted"]),
        directions=table(draw.one([0.0, 30.0, 200.0])),
    )
    shown = prompt if len(prompt) < 120 else f"{prompt[:100]}... ({len(prompt)} characters)"
    motion = _draw_motion(draw)
    return Case(f"{shown!r}, {frames} frames", lambda _: looped(prompt, scene, motion))


def _draw_sentence(draw: Draw) -> str:
    def clause() -> str:
        parts = [
            draw.one(VERBS),
            draw.one(THINGS),
            *draw.sample(HOW, draw.one([0, 0, 1, 2])),
            draw.one(WHERE),
            draw.one(WHEN),
        ]
        if draw.chance(0.2):
            draw.shuffle(parts)
        if draw.chance(0.1):
            parts.insert(0, "don't")
        return " ".join(part for part in parts if part)

    return draw.one(JOIN).join(clause() for _ in range(draw.one([1, 1, 2, 2, 3, 8])))


def _draw_known(draw: Draw) -> str:
    """A sentence of the agents' tests, with a few words lost, doubled or exchanged."""
    words = str(draw.one(SENTENCES)[0]).split()
    for _ in range(draw.one([1, 2, 4])):
        index = draw.randrange(len(words)) if words else 0
        match draw.one(["lose", "double", "exchange", "number"]):
            case "lose" if words:
                del words[index]
            case "double" if words:
                words.insert(index, words[index])
            case "exchange":
                draw.shuffle(words)
            case _:
                words.insert(index, str(draw.one([0, -1, 3, 1e9, 1e-9, "1e400", "½", "twelve", "-0"])))
    return " ".join(words)


def _draw_text(draw: Draw) -> str:
    return draw.text(60) + draw.one(["", " push it left", " drop"])


def _draw_words(draw: Draw) -> str:
    pool = (*VERBS, *HOW, *WHERE, *WHEN, *THINGS, *TEXTS)
    return " ".join(draw.one(pool) for _ in range(draw.randint(1, 12)))


def _draw_motion(draw: Draw) -> dict:
    """Draw the made-up report's motion of every window."""
    nothing: dict = {}
    unseen = {"displacement": None}
    wild = {"displacement": (draw.uniform(-3, 3), draw.uniform(-3, 3), draw.uniform(-3, 3))}
    extreme = {"displacement": (1e9, -1e9, 0.0), "turn": (0.0, 0.0, 1e9)}
    angle = draw.uniform(0, 400)
    turned = {"turn": (0.0, 0.6 * angle, 0.8 * angle), "stretch": draw.one([IDENTITY, FLAT])}
    return draw.one([nothing, unseen, wild, wild, extreme, turned])


def looped(prompt: str, scene: SceneBrief, motion: dict):
    reply = read(prompt, scene)
    report = seen_in(reply.expectations, scene.frame_count, **motion)
    history = []
    field = reply.force_field
    _check(field, scene)
    for _ in range(2):
        failed = judge(prompt, reply, report, scene, field)
        field = rewrite(prompt, reply, failed, scene, history).force_field
        history.append(failed)
        _check(field, scene)
    told = [(each.force_field, each.judgement) for each in history]
    return reply, told, field, _compile(field, scene)


def _check(field: ForceField, scene: SceneBrief) -> None:
    """The field read back from its own text: it must be inside its schema, its clip and its range."""
    again = ForceField.model_validate_json(field.model_dump_json())
    last = scene.frame_count - 1
    for action in (*again.actions, *again.constraints):
        if not MAGNITUDE_MIN - 1e-9 <= abs(action.magnitude) <= MAGNITUDE_MAX + 1e-9:
            raise Breach(Fault.SILENT, f"a magnitude of {action.magnitude}")
        window = action.active_time or (0, last)
        if not 0 <= window[0] < window[1] <= last + 1e-6:
            raise Breach(Fault.SILENT, f"a window of frames {window} in a clip of {scene.frame_count}")


def _compile(field: ForceField, scene: SceneBrief):
    """The field on particles that fill their box to the corners; the agents' own field is never refused."""
    axis = np.linspace(0.5, 1.5, 8, dtype=np.float32)
    rest = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3)
    volume, timing = np.full(len(rest), 1e-3, np.float32), (scene.frame_dt, scene.frame_count)
    duration = (scene.frame_count - 1) * scene.frame_dt
    scaling = make_closed_form_scaling(extent=1.0, youngs_modulus=1e5, density=200.0, duration=duration)
    try:
        return compile_force_field(field, scaling, rest, volume, frame_dt=timing[0], frame_count=timing[1])
    except UserError as error:
        raise Breach(Fault.SILENT, f"the agents' own force field is refused: {error}") from error
