"""A fitted model as a JSON file: exact numbers, the same bytes for the same model, a checksum, a format version."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from gtm_fmu.files import write_whole
from surrogate.models.evaluation import Variable
from surrogate.models.safety import Safety, safety_from_plain

VERSION = 2
PREFIX = "surrogate."
"""Of the format of every model; the name of its class follows."""


class StoredModel:
    """A model that a file can hold: a dataclass of numbers, arrays and parts of these."""

    safe: Safety | None
    """Margins of its safe outputs, where it was calibrated."""

    def save(self, path: str | Path) -> None:
        """Write the model to a JSON file, in one piece or not at all; `load` gives the same bits back."""
        write_model(self, Path(path))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a file that `save` wrote; ValueError, saying what is wrong, for any other file."""
        return read_model(Path(path), cls)

    @classmethod
    def from_plain(cls, content: dict[str, Any]) -> Self:
        """The model of these fields, as JSON has them."""
        parts: dict[str, Any] = {key: tuple(Variable(*pair) for pair in content[key]) for key in ("inputs", "outputs")}
        parts |= {"safe": safety_from_plain(content.get("safe"))}
        return cls(**content | parts)


def write_model(model: StoredModel, path: Path) -> None:
    """Write the model to `path`, in one piece; ValueError where that is not possible."""
    content = _plain(model)
    document = {"format": _format(type(model)), "version": VERSION, "checksum": _checksum(content), "model": content}
    text = json.dumps(document, sort_keys=True, allow_nan=False, separators=(",", ":")) + "\n"
    write_whole(path, lambda draft: draft.write_text(text, encoding="utf-8"))


def read_model(path: Path, *kinds: type[StoredModel]) -> Any:
    """The model in a file, of one of these classes; ValueError: missing, foreign, damaged, too new, another class."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"cannot read the model file '{path}' ({error.strerror}): give another path.") from error
    except (ValueError, RecursionError) as error:
        raise ValueError(f"'{path}' is not a model file or is damaged: save the model again.") from error
    found = document.get("format") if isinstance(document, dict) else None
    if not isinstance(found, str) or not found.startswith(PREFIX):
        raise ValueError(f"'{path}' is a JSON file but holds no model: give a file that a model's `save` wrote.")
    if document.get("version") != VERSION:
        raise ValueError(f"'{path}' has the format version {document.get('version')}, but only {VERSION} can be read.")
    content = document.get("model")
    if not isinstance(content, dict) or document.get("checksum") != _checksum(content):
        raise ValueError(f"'{path}' is damaged, as its checksum does not match its content: save the model again.")
    fitting = [kind for kind in kinds if _format(kind) == found]
    if not fitting:
        needed = " or a ".join(kind.__name__ for kind in kinds)
        raise ValueError(f"'{path}' holds a {found.removeprefix(PREFIX)}, but a {needed} is needed: give its file.")
    try:
        return fitting[0].from_plain(content)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise ValueError(f"'{path}' holds a model that does not fit together ({error}): save it again.") from error


def _format(kind: type) -> str:
    return f"{PREFIX}{kind.__name__}"


def _plain(value: Any) -> Any:
    """Dataclasses as objects, arrays as lists; what has kinds says its own."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if not is_dataclass(value):
        return value
    content = {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    kind = getattr(value, "KIND", None)
    return content if kind is None else content | {"kind": kind}


def _checksum(content: dict[str, Any]) -> str:
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()
