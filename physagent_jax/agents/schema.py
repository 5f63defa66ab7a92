"""Schemas that agents answer with: the semantic agent's reading, the executor's rewrite. No arrays, no jax."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from physagent_jax.core.strict import Strict
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.holds import list_motions
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, WorldRequest


class Evidence(Strict):
    """The words that led to a value, for the report.

    Attributes:
        field: The value's place, like "actions[0].vector".
        value: The value in words.
        why: The rule, in a short sentence.
    """

    words: str
    field: str
    value: str
    why: str


class SemanticReply(Strict):
    """The semantic agent's answer.

    Attributes:
        force_field: The compiled force field.
        expectations: What a viewer should see if the sentence came true; a planner that judges by the sentence itself
            needs none.
        anchor: What the sentence says about holding.
        world: What it says about gravity, ground and obstacles.
        frame_count: Frames that the clip should have for what is asked; None = as the brief says.
        ignored: Words about looks, scenery, camera or mood, which do not bear on the motion: no bar to success.
        evidence: Which words led to which value.
        not_understood: Content words that led to nothing.
        unsure: What was not understood and would change the motion, in plain sentences: no motion can then be called
            a success.
        unknown_parts: Words for parts that the object does not show: nothing is made of the sentence until they are
            known (`run.unknown_parts`).
        materials: Words for what the object is made of, as they stand in the sentence: "jelly" in "made of jelly".
        notes: Assumptions made, in plain sentences.
    """

    force_field: ForceField
    expectations: tuple[ExpectedMotion, ...] = ()
    anchor: AnchorRequest = AnchorRequest()
    world: WorldRequest = WorldRequest()
    frame_count: int | None = Field(default=None, ge=2, le=10_000)
    ignored: tuple[str, ...] = ()
    evidence: tuple[Evidence, ...] = ()
    not_understood: tuple[str, ...] = ()
    unsure: tuple[str, ...] = ()
    unknown_parts: tuple[str, ...] = ()
    materials: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def plan(self) -> tuple[ExpectedMotion, ...]:
        """The motions that are planned: those that are expected, else those that the force field tells of."""
        return self.expectations or list_motions(self.force_field)


class Rewrite(Strict):
    """The executor's answer.

    Attributes:
        force_field: The next force field, inside the hard rules.
        hold: Where the object is held from the next round on; None = as before. A hold that the user or the sentence
            chose, or excluded, is never changed.
        changes: What was changed and why, a sentence each.
        rules_applied: Names of the hard rules that shaped or overrode the result.
    """

    force_field: ForceField
    hold: Literal["base"] | None = None
    changes: tuple[str, ...]
    rules_applied: tuple[str, ...] = ()
