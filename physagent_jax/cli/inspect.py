"""`physagent inspect`: the contents of an object file, its up axis, a picture, and the command that begins a run."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from physagent_jax.forces.part import ORIGINS
from physagent_jax.scene.config import SignedAxis, SplatEncoding

if TYPE_CHECKING:
    from physagent_jax.run.findings import FoundPart, Inspection, PlannedRun


@dataclasses.dataclass(frozen=True)
class Inspect:
    """Say what an object file holds and which way up it is, and draw it from four sides.

    Prints the format and how it was read, the size, the up axis with the reason for it, loose pieces, the parts that
    a sentence can name, degenerate Gaussians, what a run would take, and the command line that begins one. The picture
    shows the parts coloured and numbered. Nothing is simulated.
    """

    file: tyro.conf.Positional[Path]
    """3D Gaussians (.ply, .spz, ...) or a mesh (.obj, .glb, .stl, .ply)."""
    up: SignedAxis | None = None
    """The file's up axis; default: its card, else its format's, else guessed from the shape."""
    kind: str | None = None
    """plant, food, robot, ...; default: its card, else from the file's name."""
    splat_encoding: SplatEncoding | None = None
    """The way in which scales and opacities are stored; default: found from the content."""
    opacity_threshold: float = 0.02
    """Gaussians with less opacity are left out."""
    part: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """A name for a part of the object, as for `physagent run`."""
    out: Path | None = None
    """PNG to draw; default: FILE's name with .preview.png, in the current folder. An earlier preview is replaced."""
    overwrite: bool = False
    """Replace a file that is no preview."""
    json_line: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object instead of sentences."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.cli.options import report_as_options
        from physagent_jax.cli.parts import parse_part
        from physagent_jax.run.inspection import inspect_object

        out = (
            Path(f"{self.file.name.removesuffix(self.file.suffix)}.preview.png")
            if self.out is None
            else self.out
        )
        with report_as_options():
            found = inspect_object(
                self.file,
                up=self.up,
                kind=self.kind,
                splat_encoding=self.splat_encoding,
                opacity_threshold=self.opacity_threshold,
                parts=list(map(parse_part, self.part)),
                preview=out,
                overwrite=self.overwrite,
            )
        if self.json_line:
            print(found.model_dump_json(indent=2))
        else:
            print("\n".join(describe_inspection(found)))
        return 0


def describe_inspection(found: Inspection) -> list[str]:
    """The inspection in lines of text."""
    from physagent_jax.cli.options import name_options

    encoding = f" ({found.encoding})" if found.encoding else ""
    kept = "all kept" if found.kept == found.count else f"{found.kept:,} kept"
    rows = [
        ("file", found.path),
        ("format", found.format + encoding),
        ("holds", f"{found.count:,} {found.content}, {kept}"),
        ("size", f"{_format_point(found.extent, ' x ')} along x, y, z in the file's units"),
        ("from, to", f"({_format_place(found, found.low)}), ({_format_place(found, found.high)})"),
    ]
    if found.origin is not None:
        rows.append(
            ("origin", f"({_format_place(found, found.origin)}) was taken off, to keep the positions' digits")
        )
    known = found.up.axis if found.up.known else "not known"
    rows.append(("up", f"{known}: {found.up.reason}"))
    rows.append(("kind", f"{found.kind.kind if found.kind.known else 'not known'}: {found.kind.reason}"))
    rows += [("loose", f"{_describe_pieces(found)}")] if found.run else []
    rows += [(f"part {each.number}", _describe_part(found, each)) for each in found.parts]
    rows += [("warning", name_options(each)) for each in found.degenerate]
    rows += [("note", name_options(each)) for each in found.notes]
    rows += [("run", _describe_run(found.run))] if found.run else []
    rows += [("refused", name_options(found.refusal))] if found.refusal else []
    if found.preview is not None:
        rows.append(("picture", found.preview))
    if found.refusal is None:
        rows.append(("command", found.command))
    return [f"{title:<9} {text}" for title, text in rows]


def _describe_part(found: Inspection, part: FoundPart) -> str:
    low, high = (_format_place(found, each) for each in (part.low, part.high))
    told = ORIGINS[part.origin] + (f" ({part.confidence:.0%} sure)" if part.origin == "shape" else "")
    return f"{part.label}, {part.share:.1%} of it, {told}, from ({low}) to ({high})"


def _describe_pieces(found: Inspection) -> str:
    if not found.pieces:
        return "nothing; all of it hangs together"
    words = [f"{each.share:.1%} of it at {each.distance:.2f} of its length" for each in found.pieces[:4]]
    more = f", and {len(found.pieces) - 4} more" if len(found.pieces) > 4 else ""
    return f"{len(found.pieces)} piece(s): {', '.join(words)}{more}"


def _describe_run(run: PlannedRun) -> str:
    return (
        f"preset {run.preset}: {run.particles:,} particles, {run.object_cells:.0f} cells along the object "
        f"({run.cells} along the domain), {run.frames} frames, at least {run.substeps:,} substeps and "
        f"{_format_time(run.seconds)} a round on two cores, {run.memory / 1e9:.1f} GB"
    )


def _format_point(point: tuple[float, ...], between: str = ", ") -> str:
    return between.join(f"{each:.4g}" for each in point)


def _format_place(found: Inspection, place: tuple[float, ...]) -> str:
    """A point with the digits that tell a thousandth of the object's size."""
    digits = max(0, 3 - math.floor(math.log10(max(*found.extent, 1e-12))))
    return ", ".join(f"{each:.{digits}f}" for each in place)


def _format_time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.1f} minutes"
