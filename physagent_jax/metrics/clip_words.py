"""Sentences as the numbers of a CLIP model's tokens, read from the model's own folder."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from tokenizers import (  # pyright: ignore[reportMissingImports]
    Regex,
    Tokenizer,
    normalizers,
    pre_tokenizers,
    processors,
)
from tokenizers import models as kinds  # pyright: ignore[reportMissingImports]

from physagent_jax.core.errors import UserError

BEGIN, END = "<|startoftext|>", "<|endoftext|>"
_WORD = r"""'s|'t|'re|'ve|'m|'ll|'d|[\p{L}]+|[\p{N}]|[^\s\p{L}\p{N}]+"""  # of Radford et al.'s own tokenizer


class Words:
    """The tokenizer of a folder.

    Args:
        folder: Holds tokenizer.json, or vocab.json and merges.txt.
        length: Tokens of a sentence; longer ones are cut before their end's token, shorter ones are filled up.

    Attributes:
        tokenizer: `tokenizers.Tokenizer`.

    Raises:
        UserError: There is no tokenizer, or it cannot be read.
    """

    def __init__(self, folder: Path, length: int):
        try:
            self.tokenizer = _read(folder)
        except UserError:
            raise
        except Exception as error:  # `tokenizers` raises the base class itself
            raise UserError(
                f"the tokenizer cannot be read ({str(error).splitlines()[0][:150]})", got=folder
            ) from None
        self.tokenizer.enable_truncation(length)
        self.tokenizer.no_padding()
        self.length = length

    def encode(self, sentence: str) -> tuple[np.ndarray, np.ndarray]:
        """Numbers and mask of a sentence, both of int32, shape (1, length).

        What fills up is 0, which no rule takes for the end, and is masked.
        """
        numbers = self.tokenizer.encode(sentence).ids
        ids, mask = np.zeros((2, 1, self.length), np.int32)
        ids[0, : len(numbers)], mask[0, : len(numbers)] = numbers, 1
        return ids, mask


def _read(folder: Path) -> Tokenizer:
    if (folder / "tokenizer.json").is_file():
        return Tokenizer.from_file(str(folder / "tokenizer.json"))
    vocabulary, merges = folder / "vocab.json", folder / "merges.txt"
    if not (vocabulary.is_file() and merges.is_file()):
        raise UserError(
            "there is no tokenizer in the folder",
            got=folder,
            do="Add tokenizer.json, or vocab.json and merges.txt",
        )
    known = json.loads(vocabulary.read_text())
    made = Tokenizer(
        kinds.BPE.from_file(str(vocabulary), str(merges), end_of_word_suffix="</w>", unk_token=END)
    )
    made.add_special_tokens([BEGIN, END])
    made.normalizer = normalizers.Sequence(
        [normalizers.NFC(), normalizers.Replace(Regex(r"\s+"), " "), normalizers.Lowercase()]
    )
    made.pre_tokenizer = pre_tokenizers.Sequence(
        [
            pre_tokenizers.Split(Regex(_WORD), behavior="removed", invert=True),
            pre_tokenizers.ByteLevel(add_prefix_space=False),
        ]
    )
    made.post_processor = processors.TemplateProcessing(
        single=f"{BEGIN} $A {END}", special_tokens=[(each, known[each]) for each in (BEGIN, END)]
    )
    return made
