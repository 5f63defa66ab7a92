"""A reply in a few words, to be compared with what a person reads."""

from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from tests.agents.scenes import brief, read

NAMES: dict[tuple[int, ...], str] = {
    (1, 0, 0): "right", (-1, 0, 0): "left", (0, 0, 1): "up", (0, 0, -1): "down", (0, -1, 0): "toward",
    (0, 1, 0): "away",
}  # fmt: skip


def ground(**changes):
    """A robot on the ground, in a clip that grows with the sentence."""
    return brief(**({"world": "ground", "frames_fixed": False, "frame_count": 51} | changes))


def tell(motion: ExpectedMotion) -> str:
    """A motion as "hit left x2 on up"."""
    words = ["hit" if motion.sudden and motion.kind is MotionKind.MOVE else motion.kind.value]
    if motion.direction is not None:
        words.append(NAMES.get(tuple(round(c) for c in motion.direction), "?"))
    words += [f"x{motion.repeats}"] if motion.repeats > 1 else []
    if motion.part is not None:
        words += ["on", NAMES.get(tuple(round(c) for c in motion.part), "?")]
    return " ".join(words)


def order(prompt: str) -> str:
    """The motions in their order; "&" joins those that begin together. The sentence must be understood."""
    reply = read(prompt, ground())
    assert reply.unsure == ()
    steps: dict[float, list[str]] = {}
    for motion in sorted(reply.expectations, key=lambda motion: motion.window[0]):
        steps.setdefault(motion.window[0], []).append(tell(motion))
    return "; ".join(" & ".join(step) for step in steps.values())
