"""All skips, in the order of the tables."""

from __future__ import annotations

from benchmarks.skipping import choices, laws, pictures, running, terms
from benchmarks.skipping.base import Skip

GROUPS: dict[str, tuple[Skip, ...]] = {
    "Terms": terms.SKIPS,
    "Laws": laws.SKIPS,
    "Grid and loop": running.SKIPS,
    "Gaussians and files": pictures.SKIPS,
    "Choices": choices.SKIPS,
}
SKIPS: dict[str, Skip] = {skip.name: skip for skips in GROUPS.values() for skip in skips}
