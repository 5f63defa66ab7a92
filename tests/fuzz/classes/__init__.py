"""The classes of cases: each module makes one kind of input and knows how to hand it to the product."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable

from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw

_warm: set[str] = set()


@dataclasses.dataclass(frozen=True)
class FuzzClass:
    """One kind of input.

    Attributes:
        name: As ``--only`` takes it.
        usual: Cases of the default test run; their ratio also splits ``--cases``.
        module: Module that makes the cases; "" = the one of the same name.
        function: Name of the function in it.
    """

    name: str
    usual: int
    module: str = ""
    function: str = "make"

    def case(self, seed: int, index: int) -> Case:
        """The case of that number: the same for the same seed."""
        make: Callable[[Draw], Case] = getattr(self._import_module(), self.function)
        return make(Draw(seed, self.name, index))

    def warm_up(self) -> None:
        """Once per process: what would otherwise be compiled on the time of the first case."""
        if self.name not in _warm:
            _warm.add(self.name)
            getattr(self._import_module(), "warm_up", lambda: None)()

    def _import_module(self):
        return importlib.import_module(f"{__name__}.{self.module or self.name}")


CLASSES = {
    each.name: each
    for each in (
        FuzzClass("gaussian_files", 400),
        FuzzClass("splat_layouts", 160),
        FuzzClass("compressed_plys", 80, "splat_formats", "make_compressed_ply"),
        FuzzClass("spz_files", 80, "splat_formats", "make_spz"),
        FuzzClass("splat_files", 80, "splat_formats", "make_splat"),
        FuzzClass("sog_bundles", 80, "splat_formats", "make_sog"),
        FuzzClass("gltf_splats", 80, "splat_formats", "make_gltf"),
        FuzzClass("meshes", 240),
        FuzzClass("motion_files", 200),
        FuzzClass("masks", 160),
        FuzzClass("cards", 120),
        FuzzClass("ballots", 80),
        FuzzClass("scenes", 400),
        FuzzClass("physgaussian", 160),
        FuzzClass("physgm", 120),
        FuzzClass("force_fields", 160),
        FuzzClass("run_folders", 80),
        FuzzClass("prompts", 160),
        FuzzClass("steps", 80),
        FuzzClass("pictures", 80),
        FuzzClass("photos", 60),
        FuzzClass("commands", 160),
    )
}

PLANTED = FuzzClass(
    "planted", 0
)  # faults on purpose, for the tests of the fuzzing itself; never drawn unasked


def named(name: str) -> FuzzClass:
    """The class of that name."""
    return PLANTED if name == PLANTED.name else CLASSES[name]


def shares(cases: int, names: list[str]) -> dict[str, int]:
    """``cases`` split over the classes as in the default run, at least one each."""
    weights = {name: named(name).usual or 1 for name in names}
    whole = sum(weights.values())
    return {name: max(1, round(cases * weight / whole)) for name, weight in weights.items()}
