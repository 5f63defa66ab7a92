"""Building HTML from small functions: whatever is not markup yet is escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable

VOID_ELEMENTS = frozenset({"br", "img", "link", "meta", "wbr"})


class Markup(str):
    """Text that is HTML already; only `tag`, `raw`, `escape` and `join` make it."""

    __slots__ = ()


Child = str | int | float | None | Iterable["Child"]


def raw(text: str) -> Markup:
    """Declare trusted text (the package's own CSS and script) to be markup."""
    return Markup(text)


def escape(text: object) -> Markup:
    """Text as markup."""
    return text if isinstance(text, Markup) else Markup(html.escape(str(text), quote=True))


def join(*children: Child) -> Markup:
    """Children in sequence; None is skipped, nested sequences are flattened, plain text is escaped."""
    return Markup("".join(_flatten(children)))


def tag(name: str, /, *children: Child, **attributes: object) -> Markup:
    """One element.

    Attribute names: a trailing underscore is dropped (``class_``), inner ones become hyphens
    (``data_frame``). None and False leave an attribute out, True writes it bare.
    """
    head = "".join(_format_attribute(key, value) for key, value in attributes.items())
    if name in VOID_ELEMENTS:
        return Markup(f"<{name}{head}>")
    return Markup(f"<{name}{head}>{join(*children)}</{name}>")


def div(class_: str, /, *children: Child, **attributes: object) -> Markup:
    """A ``div`` with a class."""
    return tag("div", *children, class_=class_, **attributes)


def span(class_: str, /, *children: Child, **attributes: object) -> Markup:
    """A ``span`` with a class."""
    return tag("span", *children, class_=class_, **attributes)


def _format_attribute(key: str, value: object) -> str:
    if value is None or value is False:
        return ""
    name = key.rstrip("_").replace("_", "-")
    return f" {name}" if value is True else f' {name}="{escape(value)}"'


def _flatten(children: Iterable[Child]) -> Iterable[str]:
    for child in children:
        if child is None:
            continue
        if isinstance(child, (str, int, float)):
            yield escape(child)
        else:
            yield from _flatten(child)
