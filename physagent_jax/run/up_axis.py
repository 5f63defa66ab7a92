"""The up axis of an object's file: stated by somebody, shown by its shape, or the usual one of such files."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from physagent_jax.gaussians.formats import LoadedSplats, find_format, read_head
from physagent_jax.run.findings import UpAxis
from physagent_jax.run.spec import ObjectChoice
from physagent_jax.scene.card import ObjectCard
from physagent_jax.scene.config import SignedAxis, Source
from physagent_jax.scene.load import load_object
from physagent_jax.scene.up_axis import UpGuess, find_mirrored, guess_up

USUAL_UP: dict[str, tuple[SignedAxis, str]] = {
    "splats": ("-y", "the axis of most captures (trained from COLMAP cameras, which are y-down)"),
    ".obj": ("+y", "the axis of most OBJ files"),
}
"""Up axes to try where nothing states one, with the reasons; "+z" for all else."""

MODELLED_UP: tuple[SignedAxis, ...] = ("+y", "+z")
"""Up axes of the programs that meshes are made with: a flat back or crown that points another way is no base."""

UPRIGHT = UpAxis(axis="+z", known=True, source="format", reason="a photo is lifted upright")


def load_as_it_lies(choice: ObjectChoice, base_dir: str | Path) -> LoadedSplats:
    """The object in its file's frame.

    Raises:
        UserError: The file cannot be used.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # they are heeded when the object is loaded in earnest
        return load_object(
            Source(**choice.model_dump(exclude={"up", "kind", "extent", "parts", "photo"})), base_dir
        )


def find_up(choice: ObjectChoice, card: ObjectCard, base_dir: str | Path) -> UpAxis:
    """The up axis of a run's object; the file is loaded only where neither the user nor a card states it.

    Raises:
        UserError: The file cannot be used.
    """
    if choice.up is not None or card.up is not None:
        return choose_up(choice, card, None, Path(base_dir))
    return choose_up(choice, card, load_as_it_lies(choice, base_dir), Path(base_dir))


def choose_up(choice: ObjectChoice, card: ObjectCard, loaded: LoadedSplats | None, base_dir: Path) -> UpAxis:
    """The up axis that somebody states, else the shape's, else the usual one of such files.

    Args:
        choice: The user's choice.
        card: The card beside the file.
        loaded: The object in its file's frame; None = what is stated is not compared with the shape.
        base_dir: Folder that a relative path starts from.
    """
    seen = None if loaded is None else guess_up(np.asarray(loaded.cloud.means, np.float64))
    stated: list[tuple[SignedAxis | None, str, str]] = [
        (choice.up, "option", "it was given"),
        (card.up, "card", "the card beside the file says so"),
    ]
    if loaded is not None:
        prescribed = f"the format {loaded.format_name} prescribes it, or the file says so"
        stated.append((loaded.up, "format", prescribed))
    for axis, source, reason in stated:
        if axis is not None:
            doubted = seen is not None and seen.axis not in (None, axis)
            if seen is not None and doubted:
                reason += f", though the shape says {seen.axis}: {seen.reason}"
            # Not every program keeps to what its format prescribes.
            known = not (doubted and source == "format")
            return UpAxis.model_validate(dict(axis=axis, known=known, source=source, reason=reason))
    assert seen is not None
    path = base_dir / choice.path
    splats = find_format(read_head(path), path) is not None
    if seen.axis is not None and (splats or seen.axis in MODELLED_UP):
        return UpAxis(axis=seen.axis, known=True, source="shape", reason=seen.reason)
    if seen.axis is not None:
        seen = UpGuess(None, f"the shape says {seen.axis}, along which hardly any mesh is modelled")
    axis, usual = USUAL_UP.get("splats" if splats else path.suffix.lower(), ("+z", "the world's own"))
    assert loaded is not None
    if "xyz".find(axis[1]) == find_mirrored(np.asarray(loaded.cloud.means, np.float64)):
        usual = f"as its left and right are along {axis[1]}"
        axis = "+z" if axis[1] == "y" else "+y"
    return UpAxis(axis=axis, known=False, source="usual", reason=f"{seen.reason}; {axis} is tried, {usual}")


def explain_up(up: UpAxis) -> tuple[str, ...]:
    """Explain in words an up axis that nobody states."""
    if up.source == "shape":
        return (f"nothing states the file's up axis: {up.axis} is taken, as {up.reason}; `--up` overrides",)
    if up.source == "usual":
        return (
            f"the file's up axis is not known: {up.reason}; pass `--up` if the object lies or stands on its head "
            "(`physagent inspect` shows it)",
        )
    return ()
