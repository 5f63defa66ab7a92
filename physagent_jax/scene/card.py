"""Object cards: what a file cannot say about itself, in a small JSON beside it.

`robot.card.json` next to `robot.ply` gives the object's name, kind, up axis and best viewing side, so that
nobody has to pass them on the command line.
"""

from __future__ import annotations

import os
from pathlib import Path

from physagent_jax.core.reading import read_model, shorten
from physagent_jax.core.strict import Strict
from physagent_jax.scene.config.common import Degrees, SignedAxis
from physagent_jax.scene.priors import find_kind


class ObjectCard(Strict):
    """Facts about an object file; every field is optional.

    Attributes:
        name: What it is called.
        kind: Class with a physical prior (`scene.priors`).
        up: The file's up axis.
        azimuth_degrees: Where to look from (`CameraConfig.azimuth_degrees`).
        credit: Source and licence.
    """

    name: str | None = None
    kind: str | None = None
    up: SignedAxis | None = None
    azimuth_degrees: Degrees | None = None
    credit: str | None = None


def load_card(object_path: str | Path) -> ObjectCard:
    """The card beside an object file; an empty one if there is none.

    Raises:
        UserError: The card is not valid, or names a kind that is not known.
    """
    path = Path(object_path)
    path = path.with_name(path.name.removesuffix(path.suffix) + ".card.json")
    if not os.path.lexists(path):
        return ObjectCard()
    card = read_model(path, ObjectCard, what="the object card")
    if card.kind is None:
        return card
    return card.model_copy(update=dict(kind=find_kind(card.kind, f"`kind` of {shorten(path)}")))
