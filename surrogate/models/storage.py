"""A fitted model as a JSON file: exact numbers, the same bytes for the same model, a checksum, a format version."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from gtm_fmu.files import write_whole
from surrogate.models.evaluation import Variable
from surrogate.models.local_models import LocalModelNetwork
from surrogate.models.network import Network
from surrogate.models.partitions import AxisPartition, ObliquePartition, Partition, SplitTree

VERSION = 2
FORMATS: dict[str, type] = {"surrogate.Network": Network, "surrogate.LocalModelNetwork": LocalModelNetwork}
PARTITIONS: dict[str, type[Partition]] = {"axis": AxisPartition, "oblique": ObliquePartition}

Model = TypeVar("Model", Network, LocalModelNetwork)


def write_model(model: Network | LocalModelNetwork, path: Path) -> None:
    """Write the model to `path`, in one piece; ValueError where that is not possible."""
    [name] = (name for name, kind in FORMATS.items() if isinstance(model, kind))
    content = _plain(model)
    document = {"format": name, "version": VERSION, "checksum": _checksum(content), "model": content}
    text = json.dumps(document, sort_keys=True, allow_nan=False, separators=(",", ":")) + "\n"
    write_whole(path, lambda draft: draft.write_text(text, encoding="utf-8"))


def load_model(path: str | Path) -> Network | LocalModelNetwork:
    """The model in a file, whichever kind it is; ValueError where it is missing, foreign, damaged or too new."""
    return _read(Path(path))


def read_model(path: Path, kind: type[Model]) -> Model:
    """The same, of this kind only."""
    model = _read(path)
    if not isinstance(model, kind):
        raise ValueError(f"'{path}' holds a {type(model).__name__}, but a {kind.__name__} is needed: give its file.")
    return model


def _read(path: Path) -> Network | LocalModelNetwork:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"cannot read the model file '{path}' ({error.strerror}): give another path.") from error
    except (ValueError, RecursionError) as error:
        raise ValueError(f"'{path}' is not a model file or is damaged: save the model again.") from error
    if not isinstance(document, dict) or document.get("format") not in [*FORMATS]:
        raise ValueError(f"'{path}' is a JSON file but holds no model: give a file that a model's `save` wrote.")
    if document.get("version") != VERSION:
        raise ValueError(f"'{path}' has the format version {document.get('version')}, but only {VERSION} can be read.")
    content = document.get("model")
    if not isinstance(content, dict) or document.get("checksum") != _checksum(content):
        raise ValueError(f"'{path}' is damaged, as its checksum does not match its content: save the model again.")
    try:
        model: Network | LocalModelNetwork = _model(FORMATS[document["format"]], content)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise ValueError(f"'{path}' holds a model that does not fit together ({error}): save it again.") from error
    return model


def _model(kind: Any, content: dict[str, Any]) -> Any:
    inputs, outputs = (tuple(Variable(*pair) for pair in content.pop(key)) for key in ("inputs", "outputs"))
    if "partition" in content:
        content["partition"] = _partition(content["partition"])
    if content.get("log_std"):
        content["log_std"] = _model(Network, content["log_std"])
    return kind(inputs=inputs, outputs=outputs, **content)


def _partition(content: dict[str, Any]) -> Partition:
    kind = PARTITIONS[content.pop("kind")]
    return kind(**content | {"tree": SplitTree(**content["tree"])})


def _plain(value: Any) -> Any:
    """Dataclasses as objects, arrays as lists; a partition says its kind."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if not is_dataclass(value):
        return value
    content = {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    for name, kind in PARTITIONS.items():
        if isinstance(value, kind):
            content["kind"] = name
    return content


def _checksum(content: dict[str, Any]) -> str:
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()
