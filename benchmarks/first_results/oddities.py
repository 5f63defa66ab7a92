"""Oddities of a run, found in the truth and in the run's own files, so that nothing is hidden."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from physagent_jax.metrics.motion import compare
from physagent_jax.perception.schema import MotionReport
from physagent_jax.run.finished import FinishedRun
from physagent_jax.simulation.record import SimulationRecord

REACH = 1.5  # cells: particles farther apart hardly feel each other through the grid
CRUMB = 1e-3  # of the particles: smaller pieces are not counted one by one
APART = 0.05  # body lengths that a piece has to leave by
CRUSHED, SWOLLEN = 0.3, 2.0  # det F beyond which matter is called so
SHIFT, SPIN, STRETCH = 0.1, 15.0, 0.1  # errors of perception worth a word [L, degrees, 1]


def find_pieces(x: np.ndarray, reach: float) -> np.ndarray:
    """Piece that each particle belongs to, shape (n,); the largest is 0.

    Args:
        x: Positions [m], shape (n, 3).
        reach: Particles up to this far apart are joined [m].
    """
    pairs = KDTree(x).query_pairs(reach, output_type="ndarray")
    joined = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(x), len(x)))
    _, labels = connected_components(joined, directed=False)
    rank = np.argsort(np.argsort(-np.bincount(labels), kind="stable"))
    return rank[labels]


def find_oddities(run: FinishedRun) -> list[str]:
    """Sentences about the best round, and what the run itself warned of."""
    best = run.best
    if best is None or best.simulation is None or best.motion is None:
        return [f"the run is not whole: {' '.join(run.problems)}"]
    found = list(pieces(run.motion().x, best.simulation))
    found += simulation(best.simulation)
    found += perception(best.motion, best.simulation)
    return found + [f"warning: {text}" for text in (run.manifest.warnings if run.manifest else ())]


def pieces(x: np.ndarray, record: SimulationRecord) -> Iterator[str]:
    """Matter that is not joined to the body, or no longer; ``x`` are the positions [m], shape (T, n, 3)."""
    x = np.asarray(x, float)
    reach, length = REACH * record.dx, np.ptp(x[0], axis=0).max()
    start, end = find_pieces(x[0], reach), find_pieces(x[-1], reach)
    for piece in range(1, start.max() + 1):
        mine, body = start == piece, start == 0
        if mine.mean() < CRUMB:
            continue
        first, last = (np.linalg.norm(at[mine].mean(0) - at[body].mean(0)) / length for at in (x[0], x[-1]))
        left = abs(last - first) > APART
        words = f"is {abs(last - first):.2f} L {'farther' if last > first else 'nearer'} at the end"
        yield (
            f"a piece of {mine.mean():.1%} of the particles is joined to the body by nothing, from the start, and "
            + (words if left else "keeps its distance")
        )
    torn = [piece for piece in range(1, end.max() + 1) if len(np.unique(start[end == piece])) == 1]
    torn = [piece for piece in torn if (end == piece).sum() < (start == start[end == piece][0]).sum()]
    if torn:
        share = np.isin(end, torn).mean()
        yield f"{len(torn)} piece(s) of {share:.2%} of the particles in all come off in the clip"


def simulation(record: SimulationRecord) -> Iterator[str]:
    """Repairs by the simulator, and extreme deformation of matter."""
    least, most = min(record.min_volume_ratio), max(record.max_volume_ratio)
    if least < CRUSHED:
        yield f"matter is pressed to {least:.2g} of its volume somewhere"
    if most > SWOLLEN:
        yield f"matter is drawn out to {most:.2g} of its volume somewhere"
    if record.stopped_particles:
        yield f"particles were stopped at the domain's wall, {record.stopped_particles} times"
    if record.redone_frames:
        reasons = "; ".join(sorted(set(record.redone_frames.values())))
        yield f"{len(record.redone_frames)} frame(s) were redone with a shorter step: {reasons}"


def perception(report: MotionReport, record: SimulationRecord) -> Iterator[str]:
    """Things that perception could not see, or saw wrongly."""
    if record.truth is not None:
        errors = compare(report, record.truth)
        for name, bar, words in (
            ("centroid_error_max", SHIFT, "the shift is misjudged by up to {:.2f} L"),
            ("rotation_error_max", SPIN, "the turn is misjudged by up to {:.0f} degrees"),
            ("stretch_error_last", STRETCH, "the stretch at the end is misjudged by {:.2f}"),
        ):
            value = errors[name]
            if value is not None and value > bar:
                yield words.format(value)
        unseen = report.frame_count - (errors["frames_observed"] or 0)
        if unseen:
            yield f"in {unseen:.0f} of {report.frame_count} frames the shift is not observable"
    for field, reason in report.windows[0].unobservable.items():
        yield f"not observable over the clip: {field.replace('_', ' ')} ({reason})"
    if report.quality.leaves_frame is not None:
        yield f"the object touches the picture's edge from frame {report.quality.leaves_frame} on"
    yield from report.quality.notes
