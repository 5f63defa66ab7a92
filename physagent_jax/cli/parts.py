"""The option `--part`: a name for a part of the object, and where the part is."""

from __future__ import annotations

import math
from typing import Any

from physagent_jax.core.errors import UserError

FORMS = (
    "--part NAME=X0,Y0,Z0,X1,Y1,Z1 (a box) or --part NAME=X,Y,Z (the part nearest to a point), both in the file's "
    "units and axes as `physagent inspect` shows them, or --part NAME=N (its number there)"
)


def parse_part(text: str) -> dict[str, Any]:
    """The fields of a `PartChoice`.

    Raises:
        UserError: The text is no name with one, three or six numbers.
    """
    name, _, place = text.rpartition("=")
    words = [word.strip() for word in place.split(",")]
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if not name.strip() or len(numbers) not in (1, 3, 6) or not all(map(math.isfinite, numbers)):
        raise UserError("`--part` is a name and where the part is", got=repr(text), do=f"Pass {FORMS}")
    field = {"name": " ".join(name.split())}
    if len(numbers) == 1:
        if not words[0].isdecimal():
            raise UserError("`--part` takes a part's number from 1 on", got=repr(text), do=f"Pass {FORMS}")
        return {**field, "number": int(words[0])}
    return {**field, "point" if len(numbers) == 3 else "box": numbers}
