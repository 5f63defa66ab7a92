"""Choice by name: options that an implementation does not take, and errors inside one."""

import dataclasses
from typing import Protocol

import pytest

from physagent_jax.agents.registry import ASK_A_MODEL, EXECUTOR, PLANNER, SEMANTIC
from physagent_jax.core.errors import UserError
from physagent_jax.core.registry import Registry
from physagent_jax.perception.backends import DEPTH_ESTIMATORS, SEGMENTERS, TRACKERS
from physagent_jax.run.models import MODELS
from tests.agents.llm.scripted import ScriptedModel

NEEDING_FILES = {card.name for card in MODELS if card.hub or card.file or card.option}


class Role(Protocol):
    def act(self) -> int: ...


class Plain(Role):
    def act(self):
        return 1


class Deeper(Plain):
    pass


class Chat(Role):
    def __init__(self, model: str, *, temperature: float = 0.0):
        self.model, self.temperature = model, temperature

    def act(self):
        return 2


class Inheriting(Chat):
    pass


@dataclasses.dataclass(frozen=True)
class Settings(Role):
    threshold: float = 0.5

    def act(self):
        return 3


class Broken(Role):
    def __init__(self, level: int = 1):
        raise TypeError("unsupported operand")


class Picky(Role):
    def __init__(self, level: int = 1):
        raise UserError("`level` is out of range", got=level)


class Counted(Role):
    def __new__(cls, count: int = 1):
        made = super().__new__(cls)
        made.count = count
        return made

    def act(self):
        return 4


def make_any(**options):
    return options


def make_with_positional(first, /, second=2):
    return first


HERE = "tests.core.test_registry"
NAMES = (
    "Plain",
    "Deeper",
    "Chat",
    "Inheriting",
    "Settings",
    "Broken",
    "Picky",
    "Counted",
    "make_any",
    "make_with_positional",
)
REGISTRY = Registry(
    "`agents.planner`", {name: f"{HERE}:{name}" for name in NAMES} | {"absent": "no_such_package:A"}
)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("Plain", {}),
        ("Deeper", {}),
        ("Chat", {"model": "a"}),
        ("Inheriting", {"model": "a", "temperature": 0.5}),
        ("Settings", {"threshold": 0.1}),
        ("Counted", {"count": 3}),
        ("make_any", {"whatever": 1}),
    ],
)
def test_options_reach_the_factory(name, options):
    REGISTRY.make((name, options))
    made = REGISTRY.make((name, options))  # again: a class that derives from a protocol has changed then
    values = made if name == "make_any" else vars(made)
    assert {key: values[key] for key in options} == options


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("Plain", {"temperature": 1}, ("does not take these options", "got temperature", "It takes none.")),
        ("Deeper", {"temperature": 1}, ("It takes none.",)),
        ("Counted", {"cuont": 1}, ("Did you mean `count`?",)),
        ("Chat", {"model": "a", "temprature": 1}, ("got temprature", "Did you mean `temperature`?")),
        ("Inheriting", {"model": "a", "x": 1, "y": 2}, ("got x, y", "Known: model, temperature.")),
        ("Settings", {"treshold": 1}, ("Did you mean `threshold`?",)),
        ("Broken", {"levl": 1}, ("Did you mean `level`?",)),
        ("Chat", {}, ("needs the options `model`",)),
        ("make_with_positional", {"first": 1}, ("got first", "second")),
    ],
)
def test_options_that_it_does_not_take_are_named(name, options, words):
    with pytest.raises(UserError) as caught:
        REGISTRY.make((name, options))
    text = str(caught.value)
    assert text.startswith(f"`agents.planner` {name!r} ") and all(word in text for word in words), text


def test_what_goes_wrong_inside_a_factory_comes_through():
    with pytest.raises(TypeError, match="unsupported operand"):
        REGISTRY.make("Broken")
    with pytest.raises(UserError, match="`level` is out of range"):
        REGISTRY.make(("Picky", {"level": 9}))


def test_a_package_that_is_missing_is_named():
    with pytest.raises(UserError, match="needs a package.*no_such_package"):
        REGISTRY.make("absent")


@pytest.mark.parametrize(
    "registry", [SEMANTIC, PLANNER, EXECUTOR, SEGMENTERS, DEPTH_ESTIMATORS, TRACKERS], ids=lambda r: r.what
)
def test_every_entry_refuses_an_option_that_nobody_has(registry):
    for name in registry.entries:
        asks = registry in (SEMANTIC, PLANNER, EXECUTOR) and name in ASK_A_MODEL
        options = {"model": ScriptedModel()} if asks else {}
        if name not in NEEDING_FILES:
            assert registry.make((name, options)).name
        with pytest.raises(UserError, match=f"{registry.what} '{name}' does not take these options"):
            registry.make((name, {**options, "flux_capacitor": 1}))
