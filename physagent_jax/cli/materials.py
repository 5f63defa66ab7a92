"""`physagent materials`: the named library, where its values come from, and what they cost to simulate."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Annotated

import tyro

CLIP_SECONDS = 2.0


@dataclasses.dataclass(frozen=True)
class Materials:
    """List the named materials, or show one with its sources.

    The stable step and the substeps of a 2 s clip are those of the fast preset's grid: what a run with
    `--material` costs without `--soften`.
    """

    name: tyro.conf.Positional[str | None] = None
    """A material; all of them if left out."""
    json_line: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print JSON instead of a table."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.scene.materials import LIBRARY, find_material

        chosen = list(LIBRARY.values()) if self.name is None else [find_material(self.name)]
        if self.json_line:
            entries = [_describe_as_json(each) for each in chosen]
            print(json.dumps(entries if self.name is None else entries[0], indent=2))
        elif self.name is None:
            _print_table(chosen)
        else:
            _print_details(chosen[0])
        return 0


def _estimate_cost(material) -> tuple[float, int]:
    from physagent_jax.scene.materials import count_substeps, stable_step
    from physagent_jax.scene.presets import PRESETS, PresetName

    dx = PRESETS[PresetName.FAST].domain.dx
    return stable_step(material, dx), count_substeps(material, dx, CLIP_SECONDS)


def _describe_as_json(each) -> dict:
    step, many = _estimate_cost(each.material)
    return {
        "name": each.name,
        "aliases": each.aliases,
        "what": each.what,
        "material": each.material.model_dump(mode="json", exclude_none=True),
        "source": each.source,
        "notes": each.notes,
        "stable_step": step if math.isfinite(step) else None,
        "substeps": many,
    }


def _print_table(entries) -> None:
    from rich import box
    from rich.table import Table

    from physagent_jax.report.facts import describe_property
    from physagent_jax.report.formats import format_count, format_quantity, spell_out
    from physagent_jax.scene.materials import describe_material

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for title in ("material", "model"):
        table.add_column(title, no_wrap=True)
    for title in ("E or K", "density", "stable step", f"substeps in {CLIP_SECONDS:g} s"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("what")
    for each in entries:
        facts = {
            name: describe_property(value, unit) for name, value, unit in describe_material(each.material)
        }
        step, many = _estimate_cost(each.material)
        stiff = facts.get("bulk modulus") or facts.get("Young\u2019s modulus", "")
        model = spell_out(each.material.model.value)
        table.add_row(
            each.name,
            model,
            stiff,
            facts["density"],
            format_quantity(step, "s"),
            format_count(many),
            each.what,
        )
    _print(table)


def _print_details(each) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from physagent_jax.report.facts import describe_property
    from physagent_jax.report.formats import format_count, format_quantity, spell_out
    from physagent_jax.scene.materials import describe_material

    step, many = _estimate_cost(each.material)
    rows = [("model", spell_out(each.material.model.value))]
    rows += [(name, describe_property(value, unit)) for name, value, unit in describe_material(each.material)]
    rows += [("stable step", f"{format_quantity(step, 's')} at the fast preset's grid spacing")]
    rows += [(f"{CLIP_SECONDS:g} s of clip", f"at least {format_count(many)} substeps")]
    rows += [("source", each.source), ("notes", each.notes)]
    if each.aliases:
        rows.append(("also called", ", ".join(each.aliases)))
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=f"{each.name}: {each.what}", show_header=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, value in rows:
        table.add_row(name, Text(value))
    _print(table)


def _print(table) -> None:
    """To standard output, at least wide enough that no column but the last is cut in a pipe."""
    from rich.console import Console

    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = max(console.width, 160)
    console.print(table)
