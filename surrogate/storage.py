"""A network as a JSON file: exact numbers, the same bytes for the same network, a checksum, a format version."""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from surrogate.network import Network, Variable

FORMAT = "surrogate.Network"
VERSION = 1


def write_network(network: Network, path: Path) -> None:
    """Write the network to `path`, through a temporary file beside it."""
    content = {f.name: _plain(getattr(network, f.name)) for f in fields(network)}
    document = {"format": FORMAT, "version": VERSION, "checksum": _checksum(content), "network": content}
    text = json.dumps(document, sort_keys=True, allow_nan=False, separators=(",", ":")) + "\n"
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        raise ValueError(f"cannot write the network file '{path}' ({error.strerror}): choose another place.") from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def read_network(path: Path) -> Network:
    """The network in `path`; ValueError where the file is missing, foreign, damaged or of another version."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"cannot read the network file '{path}' ({error.strerror}): give another path.") from error
    except ValueError as error:
        raise ValueError(f"'{path}' is not a network file or is damaged: save the network again.") from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ValueError(f"'{path}' is a JSON file but holds no network: give a file that was saved by Network.save.")
    if document.get("version") != VERSION:
        raise ValueError(f"'{path}' has the format version {document.get('version')}, but only {VERSION} can be read.")
    content = document.get("network")
    if not isinstance(content, dict) or document.get("checksum") != _checksum(content):
        raise ValueError(f"'{path}' is damaged, as its checksum does not match its content: save the network again.")
    try:
        inputs, outputs = (tuple(Variable(*pair) for pair in content.pop(key)) for key in ("inputs", "outputs"))
        return Network(inputs=inputs, outputs=outputs, **content)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"'{path}' holds a network that does not fit together ({error}): save it again.") from error


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _checksum(content: dict[str, Any]) -> str:
    canonical = json.dumps(content, sort_keys=True, allow_nan=False, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()
