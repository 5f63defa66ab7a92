"""The loading of vision models by the package `transformers`: from a folder or the hub's cache, whole or not at all."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from physagent_jax.core.errors import UserError
from physagent_jax.core.model_files import is_identifier, locate_folder
from physagent_jax.core.packages import import_package
from physagent_jax.core.reading import shorten

EXTRA = "vision"


@dataclasses.dataclass(frozen=True)
class Pretrained:
    """A model with the steps before and after it.

    Attributes:
        torch: The package.
        model, processor: Objects of `transformers`, the model on its device.
        device: Device of torch.
        name: Name of the weights: that of their folder, or "owner/name".
    """

    torch: Any
    model: Any
    processor: Any
    device: str
    name: str


def load_pretrained(
    what: str,
    weights: object,
    classes: tuple[str, str],
    kinds: tuple[str, ...],
    device: object,
    download: object,
    packages: tuple[str, ...] = (),
) -> Pretrained:
    """Load a model of a folder or of the hub's cache; no code of the folder is run.

    Args:
        what: Its name among the backends.
        weights: A folder with config.json, or "owner/name".
        classes: Names in `transformers` of the model's class and of its processor's.
        kinds: What config.json may name as the model's type.
        device: Device of torch; "auto" = a GPU if there is one.
        download: Whether files that are missing may be fetched by the hub's own client.
        packages: Packages that it needs beside torch and transformers.

    Raises:
        UserError: A package is missing, or the files are, or they are of another model or lack weights of this one.
    """
    quoted = f"`{what}`"
    place = locate_folder(weights, quoted, download=download is True)
    torch, transformers, *_ = (
        import_package(each, quoted, EXTRA) for each in ("torch", "transformers", *packages)
    )
    transformers.logging.disable_progress_bar()
    device = choose_device(torch, device)
    local = {"local_files_only": download is not True}
    try:
        kind = transformers.AutoConfig.from_pretrained(place, **local).model_type
        if kind not in kinds:
            raise UserError(
                f"the files in {shorten(place)} are not of {quoted}", got=f"a model of type {kind}"
            )
        model, told = getattr(transformers, classes[0]).from_pretrained(
            place, use_safetensors=True, output_loading_info=True, dtype=torch.float32, **local
        )
        processor = getattr(transformers, classes[1]).from_pretrained(place, **local)
        model = model.to(device).eval()
    except UserError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RuntimeError, ImportError) as error:
        raise UserError(f"the model in {shorten(place)} cannot be loaded", got=shorten(error)) from None
    if lacking := sorted(told["missing_keys"]):  # transformers fills them with random numbers
        raise UserError(f"the weights in {shorten(place)} lack some of {quoted}", got=", ".join(lacking[:3]))
    text = str(weights)
    return Pretrained(
        torch, model, processor, device, text if is_identifier(text) else Path(place).resolve().name
    )


def choose_device(torch: Any, device: object) -> str:
    """A device of torch that is there; "auto" = a GPU if there is one.

    Raises:
        UserError: It is not there.
    """
    if device == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    try:
        torch.empty(0, device=device)
    except (RuntimeError, AssertionError, TypeError) as error:
        raise UserError("`device` is none that torch can use here", got=shorten(error)) from None
    return str(device)
