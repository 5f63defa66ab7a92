"""The refusal of a sentence about a part that the object does not show: it is asked for, and nothing is simulated."""

from __future__ import annotations

from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.forces.part import list_parts, split_name
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.run.part_marks import find_owners
from physagent_jax.run.preview import draw_preview, write_preview
from physagent_jax.scene.body import Body
from physagent_jax.scene.template import SceneTemplate


class UnknownPartError(UserError):
    """A sentence names a part that the object does not show and nobody has named.

    Args:
        words: The sentence's words for such parts.
        brief: The scene.
        inspect: The command that draws the parts.
    """

    def __init__(self, words: tuple[str, ...], brief: SceneBrief, inspect: str):
        self.words, self.brief = words, brief
        told = ", ".join(map(repr, words))
        known = (
            f"the parts that are known are {list_parts(brief.parts)}"
            if brief.parts
            else "no part of it is known"
        )
        noun = split_name(words[0])[-1:] or ("part",)
        number = f"`--part {noun[0]}=N` (a number), " if brief.parts else ""
        super().__init__(
            f"Where {told} is on the {brief.object_name}, is not known: {known}",
            do=f"Say where it is: {number}`--part {noun[0]}=X,Y,Z` (a point) or "
            f"`--part {noun[0]}=X0,Y0,Z0,X1,Y1,Z1` (a box, in the file's units and axes); {inspect}",
        )


def draw_known(error: UnknownPartError, body: Body, template: SceneTemplate, path: Path) -> UserError:
    """The error with the place of a picture that shows the numbered parts; as it was if none can be written.

    Args:
        error: The refusal.
        body: The object.
        template: Its scene.
        path: The picture to write (PNG).
    """
    if not error.brief.parts:
        return error
    try:
        owner = find_owners(body, error.brief.parts)
        domain, label = template.preset.domain, f"up = {template.source.up}"
        picture = draw_preview(body.cloud, body.placement, template.camera, domain, label, owner)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_preview(path, picture)
    except (UserError, OSError):
        return error
    return UnknownPartError(error.words, error.brief, f"{path} shows the parts with their numbers")
