"""The findings of an inspection, as a value that can be printed and written."""

from __future__ import annotations

from typing import Literal

from physagent_jax.core.strict import Strict, Vector
from physagent_jax.forces.part import PartOrigin
from physagent_jax.scene.config import SignedAxis


class UpAxis(Strict):
    """The file's up axis.

    Attributes:
        axis: The axis to pass as `--up`.
        known: True = something states or shows it; False = it is only the usual one, to be compared with the picture.
        source: Where it is from.
        reason: The reason in words.
    """

    axis: SignedAxis
    known: bool
    source: Literal["option", "card", "format", "shape", "usual"]
    reason: str


class Kind(Strict):
    """The class of the object, which decides its material and what is held.

    Attributes:
        kind: A key of `scene.priors.PRIORS`.
        known: True = something states it.
        reason: The reason in words.
    """

    kind: str
    known: bool
    reason: str


class Piece(Strict):
    """A piece of the object that nothing joins to the rest.

    Attributes:
        share: Its share of the particles.
        distance: Distance from the rest [L].
    """

    share: float
    distance: float


class FoundPart(Strict):
    """A part of the object that a sentence can name.

    Attributes:
        number: Its number, from 1, for `--part NAME=N` and in the picture.
        label: What it is called.
        origin: What told of it.
        confidence: Chance that it is what it is called.
        share: Its share of the volume.
        low, high: Corners of its bounding box [file units].
    """

    number: int
    label: str
    origin: PartOrigin
    confidence: float
    share: float
    low: Vector
    high: Vector


class PlannedRun(Strict):
    """A run with the settings of its preset.

    Attributes:
        preset: The preset's name.
        particles: Number of particles.
        cells: Cells along a side of the domain.
        object_cells: Cells along the object's longest side.
        frames: Frames of the clip.
        substeps: Substeps of the clip, at least.
        seconds: Time of a round on two cores, at least [s].
        memory: Memory, at least [bytes].
    """

    preset: str
    particles: int
    cells: int
    object_cells: float
    frames: int
    substeps: int
    seconds: float
    memory: float


class Inspection(Strict):
    """The contents of an object file, and the run that it would make.

    Attributes:
        path: The file.
        format: The format's name.
        encoding: The reading of the values in words.
        content: The things that are counted.
        count: Number of Gaussians or triangles in the file.
        kept: Number of those that a run uses.
        low: Low corner of the bounding box of what is kept [file units].
        high: High corner [file units].
        extent: Sides of the bounding box [file units].
        origin: Point that was taken off the positions before they were rounded to float32 [file units]; None = none.
        up: The up axis.
        kind: The class of the object.
        pieces: Loose pieces, the nearest first.
        parts: Parts that a sentence can name.
        degenerate: Gaussians that are out of the ordinary, in words.
        notes: Sentences that a user should read before a run.
        run: The run that `command` begins; None = it cannot be planned.
        refusal: The reason why a run would be refused; None = it would not.
        command: The command line to begin with.
        preview: The picture that was written; None = none was.
    """

    path: str
    format: str
    encoding: str
    content: Literal["Gaussians", "triangles"]
    count: int
    kept: int
    low: Vector
    high: Vector
    extent: Vector
    origin: Vector | None = None
    up: UpAxis
    kind: Kind
    pieces: tuple[Piece, ...] = ()
    parts: tuple[FoundPart, ...] = ()
    degenerate: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    run: PlannedRun | None = None
    refusal: str | None = None
    command: str = ""
    preview: str | None = None
