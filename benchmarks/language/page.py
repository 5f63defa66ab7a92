"""The page of the documented language, `docs/sentences.md`: text around a table of the grammar's patterns."""

from __future__ import annotations

from pathlib import Path

from physagent_jax.agents.grammar.patterns import read_patterns

_TEXT = Path(__file__).with_name("page.md")
_TABLE = "<!-- patterns -->"


def describe_patterns() -> str:
    """The page, in Markdown."""
    head, _, tail = _TEXT.read_text(encoding="utf-8").partition(_TABLE)
    lines, group = [head.rstrip()], ""
    for pattern in read_patterns():
        if pattern.group != group:
            group = pattern.group
            lines.append(f"\n## {group}\n\n| form | for example |\n|---|---|")
        form = pattern.form.replace("|", "\\|")
        lines.append(f"| {form} | {'; '.join(pattern.examples)} |")
    return "\n".join([*lines, tail])
