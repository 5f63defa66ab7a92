"""Tables of docs/gradients.md."""

from __future__ import annotations

from benchmarks.harness import Page, Result, Tables, number, provenance, table

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


def write_tables(result: Result) -> Tables:
    """The tables of docs/gradients.md."""
    tables = {
        part: table(
            tuple(columns), [[show(row) for show in columns.values()] for row in result[part]["rows"]]
        )
        for part, columns in TABLES.items()
        if part in result
    }
    return tables | {"runs": provenance(result, PARTS)}


def _show_pair(row: dict, what: str) -> str:
    if f"forward_{what}" not in row:
        return ""
    return ", ".join(number(row[f"{way}_{what}"] / 1e6) for way in ("forward", "reverse"))


PAGE = Page(
    "gradients",
    "python -m benchmarks.gradients",
    write_tables,
    ("physagent_jax/mpm", "physagent_jax/kernels", "benchmarks/peers"),
)
