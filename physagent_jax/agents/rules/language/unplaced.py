"""Parts of an object that no direction tells the place of."""

from __future__ import annotations

# "The handle" is never the object.
UNPLACED_PARTS = frozenset(
    (
        "handle handles knob knobs lid button buttons screw screws tail string strings strap spout door lever hook "
        "horn horns finger fingers nose mouth beak paw paws tooth teeth thumb elbow knee knees rim cap sleeve cord "
        "chain zip label sticker"
    ).split()
)
