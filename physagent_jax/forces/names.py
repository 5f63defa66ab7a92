"""Names of skills: strings that are checked against the skills there are.

Read as enumerations are (``ActionType.TRANSLATION``, ``ActionType("scale")``, ``[*ActionType]``), but open: every skill
that is registered (`forces.skills`) adds its name.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, Self

from pydantic import GetCoreSchemaHandler
from pydantic_core import PydanticCustomError, core_schema


class _Known(type):
    """The names known so far, in the order of their registration."""

    known: dict[str, Any]

    def __iter__(cls) -> Iterator[Any]:
        return iter(cls.known.values())

    def __len__(cls) -> int:
        return len(cls.known)

    def __getattr__(cls, constant: str) -> Any:
        for name, value in cls.known.items() if constant.isupper() else ():
            if constant in (name.upper(), name.upper().removeprefix("ENFORCE_")):
                return value
        raise AttributeError(f"there is no skill {constant}")


class SkillName(str, metaclass=_Known):
    """One name of a kind of skill; equal names are the same object.

    Attributes:
        skill: The `forces.skills.Skill` of this name (`forces.skills.get_skill` gives it with its type).
    """

    known: ClassVar[dict[str, Any]] = {}
    skill: Any

    def __new__(cls, name: str) -> Self:
        """The name as it was registered.

        Raises:
            ValueError: No skill of this kind has the name.
        """
        if name not in cls.known:
            raise ValueError(f"{name!r} is not the name of a skill: {cls.list_names()}")
        return cls.known[name]

    @classmethod
    def add(cls, name: str, skill: Any) -> None:
        """Make a name known, with what it stands for."""
        cls.known[name] = made = str.__new__(cls, name)
        made.skill = skill

    @classmethod
    def remove(cls, name: str) -> None:
        """Make a name unknown again."""
        del cls.known[name]

    @classmethod
    def list_names(cls) -> str:
        """Every name, for a message."""
        *others, last = [f"'{name}'" for name in cls.known]
        return f"{', '.join(others)} or {last}" if others else last

    def __reduce__(self) -> tuple[type[Self], tuple[str]]:
        """A copy is the same object, and so is what another process reads."""
        return type(self), (self.value,)

    @property
    def value(self) -> str:
        """The name as a plain string."""
        return str.__str__(self)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler):
        """Validation against the names known then, and the plain string as JSON."""
        del source, handler

        def check(name: Any) -> SkillName:
            if isinstance(name, str) and name in cls.known:
                return cls.known[name]
            raise PydanticCustomError("enum", "Input should be {expected}", {"expected": cls.list_names()})

        return core_schema.no_info_plain_validator_function(
            check, serialization=core_schema.plain_serializer_function_ser_schema(lambda name: name.value)
        )

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: Any, handler: Any) -> dict[str, Any]:
        """An enumeration of the names known by then."""
        del schema, handler
        return {"enum": [*cls.known], "type": "string"}


class ActionType(SkillName):
    """Name of a skill that acts by forces."""

    known: ClassVar[dict[str, Any]] = {}


class ConstraintType(SkillName):
    """Name of the other kind of skill: velocities are prescribed instead of forces."""

    known: ClassVar[dict[str, Any]] = {}
