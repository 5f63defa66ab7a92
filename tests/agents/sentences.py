"""Tables of sentences beside the tests, from YAML."""

from pathlib import Path
from typing import Any

import yaml


def load_table(name: str) -> Any:
    """The content of a YAML file of this folder; a sentence that stands twice in a mapping is an error."""
    return yaml.load(Path(__file__).with_name(name).read_text(encoding="utf-8"), _Loader)  # noqa: S506


class _Loader(yaml.CSafeLoader):
    def construct_mapping(self, node, deep=False):
        mapping = super().construct_mapping(node, deep)
        assert len(mapping) == len(node.value), f"a key stands twice: {node.start_mark}"
        return mapping


SENTENCES = [
    (row["text"], "anchored" if row.get("held") else "", row["actions"], row["motions"])
    for row in load_table("sentences.yaml")
]
"""(prompt, "anchored" or "", actions, expectations), in the notation that the file tells."""
