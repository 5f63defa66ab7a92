"""The page of what gradients cost."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness import link, number, provenance, table

_MEANING = """What the gradient of a simulation costs, by `python -m benchmarks.gradients`. The elastic cube that the
codes are timed on, dropped on a floor, with eight particles per cell. *Forward* is what the product runs (`simulate`,
with its window and kernels); *value and gradient* is `jax.value_and_grad` through `replay` of its schedule, by
gravity, initial velocity and stiffness. Both in turn, warm; median and range of the ratio. *Memory* is what the
process takes more at its peak; *allowed* is what `replay` was given. *Precision*: the gradient by the kernels in
single precision against that of the reference path in double precision, of 1,000 particles, and that one against
central differences. *Peers*: the same scene, loss and unknowns by the automatic differentiation of Warp (kernels of
the classical substep, every substep's arrays on the tape) and of Taichi (as in DiffTaichi: nodes are filled again in
reverse), each in a process of its own with as many cores; Warp has one thread on a CPU. Ours sorts the particles by
cell as it loads them; the peers are given them sorted, which is the strict comparison, and in random order, as their
users have them. Codes take turns, in three rounds; a gradient is timed after three that are not. At one moment the two
cores of this virtual machine have a cache in common and at the next they have not, which the time tells that a word
takes from one to the other (some 50 or 180 ns, `benchmarks.latency`), asked before and after each repeat: rows are
apart by it. *Fastest by fastest* is the ratio of the least times. The aim, five times as fast as either peer on two
cores, is met where the cores share a cache, and just met by the medians where they do not (4.8 by the fastest). Before
2026-11-25 ours took 1.05 and 1.43 s here (two cores, one); what changed is in docs/decisions.md. On Intel Xeon machines
with two cores, particles in random order and that earlier code, Warp took 10.1 and 7.1 times ours in one run, 5.4 and
3.7 in another, Taichi 5.5 and 6.4, and 5.0 and 5.0; why Warp's times differ is not known. Taichi finds its compiled
kernels again from an earlier run; without them its first call takes 150 to 190 s. *Cosine* is between the gradients:
the classical stress form and MLS-MPM differ at this resolution. *Materials* and *growth* are cost and precision for
the other laws: the impact makes metal and sand yield, so that their gradients go through the return mapping.
*Profile*: each stage of a substep, and its derivative, jitted alone, with the floor: the larger of the bytes that
must go in and out over the bandwidth of a copy of as many, and the operations that XLA counts in the reference path
over those of a matrix product. The reverse of the whole is its value and gradient less its forward; stages alone pay
for a call each.
"""
COLUMNS = {
    "particles": lambda row: f"{row['particles']:,}",
    "substeps": lambda row: f"{row['substeps']:,}",
    "forward [ms per substep]": lambda row: number(row["forward_ms"]),
    "value and gradient [ms per substep]": lambda row: number(row["gradient_ms"]),
    "times the forward": lambda row: (
        f"{number(row['ratio'])} ({' to '.join(map(number, row['ratio_range']))})"
    ),
    "aim": lambda row: number(row["aim"]),
    "memory [GB]": lambda row: number(row["memory_gb"]),
    "allowed [GB]": lambda row: number(row["allowed_gb"]),
    "first calls [s]": lambda row: ", ".join(map(number, row["first_seconds"])),
}
PRECISION = {
    "substeps": lambda row: f"{row['substeps']:,}",
    "cosine": lambda row: f"{row['cosine']:.7f}",
    "relative error": lambda row: f"{row['error']:.1e}",
    "norm": lambda row: number(row["norm"]),
    "double precision against central differences": lambda row: f"{row['difference_error']:.1e}",
}
MATERIAL_COLUMNS = {"material": lambda row: row["material"]} | COLUMNS
GROWTH = {"material": lambda row: row["material"]} | PRECISION
PEERS = {
    "code": lambda row: f"{row['code']}: {row['version']}",
    "cores": lambda row: (
        f"{row['cores']}, {'a cache each' if row['caches'] == 'two' else 'one cache'}"
        if row["cores"] > 1
        else "1"
    ),
    "order": lambda row: row["order"],
    "particles": lambda row: f"{row['particles']:,}",
    "substeps": lambda row: str(row["substeps"]),
    "value and gradient [s]": lambda row: (
        f"{number(row['seconds'])} ({' to '.join(map(number, row['range']))})"
    ),
    "repeats": lambda row: str(row["repeats"]),
    "times ours": lambda row: number(row["ratio"]),
    "fastest by fastest": lambda row: number(row["ratio_of_fastest"]),
    "first call [s]": lambda row: number(row["first_seconds"]),
    "memory [GB]": lambda row: number(row["memory_gb"]),
    "cosine with ours": lambda row: f"{row['cosine']:.4f}",
}

PROFILE = {
    "stage": lambda row: row["stage"],
    "particles": lambda row: f"{row['particles']:,}",
    "forward [ms]": lambda row: number(row["forward_ms"]),
    "floor [ms]": lambda row: number(row["forward_floor_ms"]),
    "reverse [ms]": lambda row: number(row["reverse_ms"]),
    "its floor [ms]": lambda row: number(row["reverse_floor_ms"]),
    "moved, there and back [MB]": lambda row: _show_pair(row, "bytes"),
    "million operations, there and back": lambda row: _show_pair(row, "operations"),
}

TABLES = {
    "cost": COLUMNS,
    "precision": PRECISION,
    "peers": PEERS,
    "materials": MATERIAL_COLUMNS,
    "growth": GROWTH,
    "profile": PROFILE,
}
PARTS = tuple(TABLES)


def document(result: dict, json_path: Path, target: Path) -> str:
    """The tables as Markdown."""
    text = f"# Gradients\n\n{_MEANING}\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
    text += provenance(result, PARTS)
    for part, columns in TABLES.items():
        if part in result:
            rows = [[show(row) for show in columns.values()] for row in result[part]["rows"]]
            text += f"\n## {part.capitalize()}\n" + table(tuple(columns), rows)
    return text


def _show_pair(row: dict, what: str) -> str:
    if f"forward_{what}" not in row:
        return ""
    return ", ".join(number(row[f"{way}_{what}"] / 1e6) for way in ("forward", "reverse"))
