"""Findings about an object that are made once and then read from the disk."""

import dataclasses
import os

import numpy as np
import pytest

from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.scene import store
from physagent_jax.scene.burden import Burden

CELLS = CellsRegion(inside=((0.1, 1 / 3, 0.5),), outside=((0.7, 0.2, 0.9),))
ARM = Part(roles=("arm",), moved=CELLS, rest=CELLS, joint=(0, 0, 0), arm=(1, 0, 0), side=(1, 0, 0), share=0.1)


@dataclasses.dataclass(frozen=True)
class Named:
    name: str
    mask: np.ndarray


@pytest.fixture
def finder(tmp_path, monkeypatch):
    """A function that is kept, its calls, and the folder that it is kept in."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    calls = []

    @store.keep
    def find(points, groups=(), *, limb=False) -> tuple[Part, ...]:
        calls.append(len(points))
        return (ARM,)

    return find, calls, tmp_path / "physagent_jax" / "objects"


def test_equal_arguments_are_read_from_the_disk(finder):
    find, calls, folder = finder
    points = np.linspace(0, 1, 12).reshape(4, 3)
    assert find(points) == find(points.copy()) == (ARM,)
    assert len(calls) == 1 and len(list(folder.iterdir())) == 1


@pytest.mark.parametrize(
    "change",
    [
        lambda points, groups: (np.nextafter(points, 2), groups),
        lambda points, groups: (points.astype(np.float32), groups),
        lambda points, groups: (points.reshape(3, 4), groups),
        lambda points, groups: (points, groups[:1]),
        lambda points, groups: (points, [groups[0], dataclasses.replace(groups[1], name="leg")]),
        lambda points, groups: (points, [groups[0], dataclasses.replace(groups[1], mask=~groups[1].mask)]),
    ],
)
def test_other_arguments_are_searched(finder, change):
    find, calls, _ = finder
    points, groups = np.ones((4, 3)), [Named(name, np.arange(4) > 1) for name in ("arm", "tail")]
    find(points, groups)
    find(*change(points, groups))
    assert len(calls) == 2
    find(points, groups, limb=True)
    assert len(calls) == 3


@pytest.mark.parametrize("damage", [b"", b"[]]", b'[{"roles": ["arm"]}]', b"\xff\xfe"])
def test_a_damaged_entry_is_found_again(finder, damage):
    find, calls, folder = finder
    find(np.ones((4, 3)))
    (entry,) = folder.iterdir()
    entry.write_bytes(damage)
    assert find(np.ones((4, 3))) == (ARM,) and len(calls) == 2
    assert find(np.ones((4, 3))) == (ARM,) and len(calls) == 2


def test_other_code_finds_anew(finder, monkeypatch):
    find, calls, _ = finder
    find(np.ones((4, 3)))
    monkeypatch.setattr(store, "digest_sources", lambda: "other")
    find(np.ones((4, 3)))
    assert len(calls) == 2


def test_the_oldest_entries_go(finder, monkeypatch):
    find, calls, folder = finder
    find(np.ones((1, 3)))
    (entry,) = folder.iterdir()
    monkeypatch.setattr(store, "MOST_BYTES", 3.5 * entry.stat().st_size)
    os.utime(entry, (0, 0))
    for count in range(2, 6):
        find(np.ones((count, 3)))
    assert len(list(folder.iterdir())) == 3
    find(np.ones((5, 3)))
    assert len(calls) == 5
    find(np.ones((1, 3)))
    assert len(calls) == 6


def test_numbers_are_kept_to_the_last_bit(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    numbers = np.random.default_rng(0).normal(size=50) * 10.0 ** np.arange(-25, 25)
    calls = []

    @store.keep
    def measure(x) -> Burden:
        calls.append(x)
        return Burden(1 / 3, 0.1, 2.0, 0.0, numbers)

    first, again = measure(numbers), measure(numbers)
    assert len(calls) == 1 and again.strain == first.strain
    assert again.needed.dtype == np.float64 and (again.needed == numbers).all()
