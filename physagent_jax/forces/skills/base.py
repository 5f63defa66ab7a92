"""The base of a skill: everything that the package asks about one.

Agents, report, simulation and search methods know skills by these attributes and methods alone. Arrays are imported
inside the methods that need them: agents read skills without them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from physagent_jax.forces.skills.icons import Mark, draw_arrow

if TYPE_CHECKING:
    from physagent_jax.forces.binding import Binding, FreeEntry
    from physagent_jax.forces.schema import SkillScaling


class Skill:
    """One skill of the library; subclasses are instantiated once, in `forces.skills`.

    Attributes:
        name: Name in the JSON: ``action_type`` or ``constraint_type``.
        group: Place in a force field; constraints prescribe velocities instead of forces.
        meaning: Effect in words for a language model; continues "`name`: ".
        one_means: Effect of M = 1 in words for people.
        quantity: Field of `SkillScaling` that k goes by.
        factor: Ratio of k to that quantity.
        unit: Unit of k.
        effect: Effect of one entry in words, with {direction}, {turn} or {axis}.
        reverse_effect: The same for a negative magnitude; None = the vector's sign says it.
        causes: Motion kinds that it can bring about, as `motion.schema.MotionKind` names them.
        nouns: Names of the cause by which a sentence reaches it ("gust"), beside what the lexicon says of them.
        verbs: Verbs by which a sentence reaches it; "~" stands for up to four words.
        towards: The viewer's word for the direction or axis of a sentence that names none.
        is_axis: Whether the vector is an axis of rotation (right-hand rule) and no direction.
        is_two_sided: Whether v and -v mean the same, and the magnitude's sign alone reverses it.
        is_sudden: Whether it acts in an instant, so that its window is short.
        is_brief: Whether it is over in a part of the time that a sentence gives it.
        is_memoryless: Whether it acts the same at each instant of its window, however long that is.
        superposes: Whether its response in a window follows from that in the whole clip (`baselines.responses`).
        swings: Whether several to and fro are taken for a swing (`forces.swinging`).
        prescribed_by: Name of the velocity constraint that brings about the same motion; None = none does.
        stacks_with: Name of the skill that it counts as where magnitudes add up; None = its own.
        deforms: Shape that a constraint changes: "ends" moves an end in or out, "plates" press; None = neither.
    """

    name: str
    group: Literal["actions", "constraints"] = "actions"
    meaning: str
    one_means: str
    quantity: str
    factor: float = 1.0
    unit: str
    effect: str
    reverse_effect: str | None = None
    causes: tuple[str, ...] = ()
    nouns: tuple[str, ...] = ()
    verbs: tuple[str, ...] = ()
    towards: str | None = None
    is_axis: bool = False
    is_two_sided: bool = False
    is_sudden: bool = False
    is_brief: bool = False
    is_memoryless: bool = True
    superposes: bool = True
    swings: bool = False
    prescribed_by: str | None = None
    stacks_with: str | None = None
    deforms: Literal["ends", "plates"] | None = None

    @property
    def prescribes(self) -> bool:
        """Return whether it prescribes a velocity for a while: what it does is that times how long it lasts."""
        return self.group == "constraints" and not self.is_sudden

    def find_k(self, scaling: SkillScaling, vector: Any) -> Any:
        """The k of M = 1 along a vector, in `unit`."""
        del vector
        return self.factor * getattr(scaling, self.quantity)

    def explain_one(self, scaling: SkillScaling, vector: Any, swing: float | None) -> tuple[float, str]:
        """The k of an entry and its meaning, for the report.

        Args:
            scaling: The scene's.
            vector: The entry's.
            swing: The k of one of several pushes to and fro; None = it is none.
        """
        del swing
        return float(self.find_k(scaling, vector)), self.one_means

    def make_forces(self, bound: Binding) -> list:
        """The body forces of an entry (`mpm.protocols.BodyForce`), differentiable in its numbers."""
        del bound
        return []

    def make_constraints(self, bound: Binding) -> list:
        """The constraints of an entry (`mpm.protocols.Constraint`)."""
        del bound
        return []

    def make_pair(self, bound: Binding, other: Binding | None, sign: float) -> list:
        """The constraints of an entry and of its partner at the other end, in place of their own (`forces.pairs`).

        Args:
            bound: The entry.
            other: Its partner; None = the ground or the fixture.
            sign: 1 if the vector points out of the object at the entry's end, -1 if into it.
        """
        raise NotImplementedError(f"{self.name} acts on no two ends")

    def accelerate(self, gained: Any, entry: FreeEntry) -> Any:
        """Changes of velocity of a free body in each interval between frames, with this entry's [m/s].

        Args:
            gained: The same by the entries before, shape (frames - 1, 3).
            entry: The entry and its window.
        """
        del entry
        return gained

    def draw_icon(self, reverse: bool) -> tuple[Mark, ...]:
        """The lines of its icon; the vector as the entry means it is their first axis.

        Args:
            reverse: Whether the magnitude is negative; only a two-sided skill looks different then.
        """
        del reverse
        return draw_arrow()
