"""Sources of cases: seeded draws, edge values, damaged bytes, damaged JSON, and schemas turned into data.

Everything follows from ``(seed, class, index)``, so that one line repeats a case.
"""

from __future__ import annotations

import json
import math
import random
import re
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

T = TypeVar("T")

NUMBERS = (
    0, 1, -1, 2, 3, 0.5, -0.0, 0.1, 1e-3, 1e-9, 1e-38, 1e-45, 1e-300, 5e-324, -1e-300, 100, 1e3, 1e6, 1e9, 1e15, 1e30,
    3.4e38, 1e39, 1e300, 1.7e308, -1e300, -3.5, 89.999, 90, 180, 360, 2**31 - 1, 2**31, 2**32, 2**53 + 1, 2**63, 2**64,
    -(2**31), -(2**63) - 1, 10**30, 10**400, -(10**400),
)  # fmt: skip
TEXTS = (
    "", " ", "0", "-1", "nan", "NaN", "inf", "-Infinity", "1e400", "null", "none", "true", "../../etc/passwd", "/", ".",
    "~", "\n", "\0", "\ud800", "\u202egnirts", "ü", "機器人", "🤖", "a" * 300, "x" * 5000, "%s%n{0}{}", "[red]",
    "'", '"',
)  # fmt: skip
OTHERS: tuple[Any, ...] = (
    None,
    True,
    False,
    [],
    {},
    [[]],
    [1],
    [1, 2, 3],
    {"a": 1},
    ["a"],
    [None],
    {"": None},
)
# Text that JSON's own writer would not write.
RAW = (
    "NaN", "Infinity", "-Infinity", "1e999", "-1e999", "1" * 400, "-" + "9" * 5000, "0." + "1" * 5000, "1e-999", "01",
    "1e", "0x10", "[" * 2000 + "]" * 2000, "[" * 100_000, '{"a":' * 3000 + "1" + "}" * 3000, '"\\ud800"', "tru", "",
)  # fmt: skip
_TOKEN = "%raw{}%"
_CHARACTERS = (
    (0x20, 0x7E), (0x20, 0x7E), (0x61, 0x7A), (0x00, 0x1F), (0x7F, 0xFF), (0x300, 0x36F), (0x400, 0x4FF),
    (0x590, 0x6FF),
    (0x2000, 0x206F), (0x4E00, 0x4FFF), (0xD800, 0xDFFF), (0xFE00, 0xFFFF), (0x1F300, 0x1F6FF),
)  # fmt: skip


class Draw(random.Random):
    """A seeded source of choices for one case."""

    def __init__(self, *key: object):
        self.key = "/".join(map(str, key))
        super().__init__(self.key)

    def one(self, options: Sequence[T]) -> T:
        """One of them."""
        return self.choice(options)

    def chance(self, probability: float) -> bool:
        """True so often."""
        return self.random() < probability

    def number(self) -> Any:
        """A number at some edge, or an ordinary one."""
        if self.chance(0.7):
            return self.one(NUMBERS)
        return self.one([self.randint(-100, 1000), self.uniform(-10, 10), 10 ** self.uniform(-40, 40)])

    def value(self) -> Any:
        """Any JSON value at some edge."""
        return self.one([self.number, self.number, lambda: self.one(TEXTS), lambda: self.one(OTHERS)])()

    def text(self, most: int = 12) -> str:
        """Any characters: letters of several scripts, signs, controls, halves of pairs."""
        return "".join(chr(self.randint(*self.one(_CHARACTERS))) for _ in range(self.randint(0, most)))


# --- bytes ---------------------------------------------------------------------------------------------


def damaged(draw: Draw, content: bytes, others: Sequence[bytes] = ()) -> tuple[str, bytes]:
    """``content`` with one to three kinds of damage, and what they were; ``others`` to splice with."""
    done = []
    for _ in range(draw.one([1, 1, 1, 2, 3])):
        name, damage = draw.one(_DAMAGES)
        content = damage(draw, content, [*others, content])
        done.append(name)
    return ", ".join(done), content


def _flip(draw: Draw, content: bytes, _) -> bytes:
    buffer = bytearray(content)
    for _ in range(draw.one([1, 1, 3, 30]) if buffer else 0):
        buffer[draw.randrange(len(buffer))] ^= 1 << draw.randrange(8)
    return bytes(buffer)


def _truncate(draw: Draw, content: bytes, _) -> bytes:
    return content[: draw.randint(0, len(content))]


def _duplicate(draw: Draw, content: bytes, _) -> bytes:
    start, stop = sorted(draw.randint(0, len(content)) for _ in range(2))
    return content[:stop] + content[start:stop] * draw.one([1, 1, 50]) + content[stop:]


def _delete(draw: Draw, content: bytes, _) -> bytes:
    start = draw.randint(0, len(content))
    return content[:start] + content[start + draw.one([1, 2, 4, 50]) :]


def _splice(draw: Draw, content: bytes, others: Sequence[bytes]) -> bytes:
    other = draw.one(others)
    return content[: draw.randint(0, len(content))] + other[draw.randint(0, len(other)) :]


def _insert(draw: Draw, content: bytes, _) -> bytes:
    at = draw.randint(0, len(content))
    extra = draw.one(
        [b"\0", b"\xff" * 8, b"\n", b" ", b"\r\n", b"1e400 ", b"nan ", b"-", b"\xc3\x28", b"9" * 5000]
    )
    return content[:at] + extra + content[at:]


def _exchange_number(draw: Draw, content: bytes, _) -> bytes:
    """Another number for one that stands there in digits, in the first part, where headers are."""
    found = list(re.finditer(rb"-?\d+(\.\d+)?(e[-+]?\d+)?", content[:4096]))
    if not found:
        return _flip(draw, content, _)
    number = draw.one(found)
    new = draw.one(
        [repr(draw.number()) if abs(draw.number()) < 1e308 else "1e999", "nan", "inf", "9" * 25, "-1", ""]
    )
    return content[: number.start()] + new.encode() + content[number.end() :]


def _swap_words(draw: Draw, content: bytes, _) -> bytes:
    """Two words of the first part change places."""
    found = list(re.finditer(rb"[A-Za-z_][A-Za-z_0-9]+", content[:4096]))
    if len(found) < 2:
        return _flip(draw, content, _)
    one, two = sorted(draw.sample(found, 2), key=lambda match: match.start())
    between = content[one.end() : two.start()]
    return content[: one.start()] + two.group() + between + one.group() + content[two.end() :]


def _overwrite_float(draw: Draw, content: bytes, _) -> bytes:
    """Four or eight bytes that read as an extreme number."""
    patterns = (
        "0000c07f",
        "0000807f",
        "000080ff",
        "ffff7f7f",
        "01000000",
        "ffffffff",
        "ffffff7f",
        "00000080",
    )
    pattern = bytes.fromhex(draw.one(patterns)) * draw.one([1, 2])
    at = draw.randint(0, max(0, len(content) - len(pattern)))
    return content[:at] + pattern + content[at + len(pattern) :]


_DAMAGES: tuple[tuple[str, Callable[[Draw, bytes, Sequence[bytes]], bytes]], ...] = (
    ("flipped", _flip),
    ("truncated", _truncate),
    ("duplicated", _duplicate),
    ("deleted", _delete),
    ("spliced", _splice),
    ("inserted", _insert),
    ("another number", _exchange_number),
    ("another number", _exchange_number),
    ("words exchanged", _swap_words),
    ("extreme bits", _overwrite_float),
    ("extreme bits", _overwrite_float),
)

# --- JSON ----------------------------------------------------------------------------------------------


def places(data: Any, here: tuple = ()) -> list[tuple]:
    """Paths of all values within ``data``, itself first."""
    inner: list[tuple[Any, Any]] = []
    if isinstance(data, dict):
        inner = list(data.items())
    elif isinstance(data, list):
        inner = list(enumerate(data))
    return [here, *(path for key, value in inner for path in places(value, (*here, key)))]


def at(data: Any, path: Sequence) -> Any:
    """The value at ``path``."""
    for key in path:
        data = data[key]
    return data


def altered(draw: Draw, data: Any) -> tuple[str, bytes]:
    """``data`` as JSON text with one to three values, keys or literals changed, and what was done."""
    raw: list[str] = []
    done = []
    for _ in range(draw.one([1, 1, 1, 1, 2, 3])):
        data = json.loads(json.dumps(data))  # a copy, in which no part is there twice
        paths = [path for path in places(data) if path]
        if not paths:
            break
        path = draw.one(paths)
        parent, key = at(data, path[:-1]), path[-1]
        shown = ".".join(map(str, path))
        match draw.one(["value"] * 8 + ["kin"] * 4 + ["raw", "delete", "add", "twice", "wrap", "rename"]):
            case "value":
                parent[key] = draw.value()
                done.append(f"{shown} = {_shorten(parent[key])}")
            case "kin":  # of the same type
                parent[key] = _draw_kin(draw, parent[key])
                done.append(f"{shown} = {_shorten(parent[key])}")
            case "raw":
                raw.append(draw.one(RAW))
                parent[key] = _TOKEN.format(len(raw) - 1)
                done.append(f"{shown} = {raw[-1][:20]} ({len(raw[-1])} characters)")
            case "delete":
                del parent[key]
                done.append(f"{shown} deleted")
            case "add":
                where = parent[key] if isinstance(parent[key], dict) else data
                if isinstance(where, dict):
                    where[draw.one(("x", "kind", "", "Version", *TEXTS[-8:]))] = draw.value()
                done.append(f"a key more in {shown}")
            case "twice":
                if isinstance(parent, list):
                    parent.extend([parent[key]] * draw.one([1, 5, 200]))
                done.append(f"{shown} several times")
            case "wrap":
                parent[key] = draw.one([[parent[key]], {"value": parent[key]}, str(parent[key])])
                done.append(f"{shown} wrapped")
            case "rename":
                if isinstance(parent, dict):
                    parent[f"{key}_"] = parent.pop(key)
                done.append(f"{shown} renamed")
    return "; ".join(done), encoded(data, raw)


def encoded(data: Any, raw: Sequence[str] = ()) -> bytes:
    """JSON text with literals put in for their tokens; lone surrogates stay escaped."""
    text = json.dumps(data)
    for index, literal in enumerate(raw):
        text = text.replace(json.dumps(_TOKEN.format(index)), literal)
    return text.encode("utf-8", "surrogatepass")


def _draw_kin(draw: Draw, value: Any) -> Any:
    """Another value of the same type: what passes the first check."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return draw.one([0, 1, -1, 2, 7, 16, 100, 4096, 10_000, 10**6, 2**31, 2**63, 10**30])
    if isinstance(value, float):
        return float(draw.one([n for n in NUMBERS if abs(n) < 1e308]))
    if isinstance(value, str):
        return draw.one(TEXTS)
    if isinstance(value, list):
        return draw.one([[], value * 2, value[:1], list(reversed(value)), [draw.number() for _ in value]])
    if isinstance(value, dict):
        return {**value, draw.one(["x", *value]): draw.value()}
    return draw.value()


def _shorten(value: Any) -> str:
    try:
        text = repr(value)
    except ValueError:  # integers of more digits than Python writes
        return "a very long integer"
    return text if len(text) <= 60 else f"{text[:50]}... ({len(text)} characters)"


# --- whole documents -----------------------------------------------------------------------------------


def any_json(draw: Draw, depth: int = 3) -> Any:
    """Any value that JSON has."""
    kind = draw.one(["number", "number", "text", "other", "list", "object"])
    if kind in ("list", "object") and depth:
        parts = [any_json(draw, depth - 1) for _ in range(draw.randint(0, 4))]
        return parts if kind == "list" else {draw.text(6): part for part in parts}
    return {"number": draw.number, "text": draw.text}.get(kind, lambda: draw.one(OTHERS))()


def of_schema(draw: Draw, schema: dict) -> Any:
    """A value that a JSON Schema (pydantic's) allows: right in form, at the edges in content."""
    return _draw_for_node(draw, schema, schema.get("$defs", {}))


def _draw_for_node(draw: Draw, node: dict, definitions: dict) -> Any:
    if "$ref" in node:
        return _draw_for_node(draw, definitions[node["$ref"].split("/")[-1]], definitions)
    if "const" in node:
        return node["const"]
    for key in ("enum", "anyOf", "oneOf", "allOf"):
        if key in node:
            chosen = draw.one(node[key])
            return chosen if key == "enum" else _draw_for_node(draw, chosen, definitions)
    match node.get("type"):
        case "object":
            return _draw_for_object(draw, node, definitions)
        case "array" if "prefixItems" in node:
            return [_draw_for_node(draw, item, definitions) for item in node["prefixItems"]]
        case "array":
            least = node.get("minItems", 0)
            count = draw.randint(least, max(least, min(node.get("maxItems", 3), 3)))
            return [_draw_for_node(draw, node.get("items", {}), definitions) for _ in range(count)]
        case "integer" | "number" as kind:
            return _draw_in_range(draw, node, kind == "integer")
        case "string":
            return draw.one([draw.text(), draw.one(TEXTS[:26])])
        case "boolean":
            return draw.chance(0.5)
        case "null":
            return None
    return any_json(draw, 1)


def _draw_for_object(draw: Draw, node: dict, definitions: dict) -> dict:
    if "properties" not in node:
        values = node.get("additionalProperties") or {}
        return {draw.text(6): _draw_for_node(draw, values, definitions) for _ in range(draw.randint(0, 3))}
    needed, often = {"kind", *node.get("required", ())}, draw.random()
    return {
        name: _draw_for_node(draw, part, definitions)
        for name, part in node["properties"].items()
        if name in needed or draw.chance(often)
    }


def _draw_in_range(draw: Draw, node: dict, whole: bool) -> Any:
    low = node.get("minimum", node.get("exclusiveMinimum", -math.inf))
    high = node.get("maximum", node.get("exclusiveMaximum", math.inf))
    edges = [n for n in (*NUMBERS, low, high) if low <= n <= high and abs(n) < 1e308]
    if whole:
        return int(draw.one([n for n in edges if n == int(n)] or [0]))
    near = draw.uniform(max(low, -2.0), min(high, max(low, 0) + 2.0))
    return near if draw.chance(0.5) else float(draw.one(edges or [0.0]))
