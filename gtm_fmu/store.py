"""The zarr store of a data set, filled chunk by chunk.

Every input and result is an array over ``case``. A chunk is a slice of all of them; its files are each written in one
piece, and ``finished`` last. So a store that was left at any moment holds whole chunks and knows which.
"""

import fcntl
import hashlib
import os
import shutil
import socket
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from zarr.codecs import ZstdCodec

from gtm_fmu import results
from gtm_fmu.cases import CaseTable
from gtm_fmu.core import library_path
from gtm_fmu.errors import InputError
from gtm_fmu.inputs import attributes

FINISHED = "finished"
SMALLEST_CHUNK, LARGEST_CHUNK = 64, 1024
"""Cases; in between some 64 chunks a store."""


def chunk_size(cases: int) -> int:
    """Cases a chunk of a store of that size."""
    power_of_two = 1 << (cases // 64).bit_length()
    return min(max(power_of_two, SMALLEST_CHUNK), LARGEST_CHUNK)


def identity(table: CaseTable, options: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes that tell what the values of a store follow from; a store is only continued if all are the same."""
    versions = {f"{package}_version": version(package) for package in ("numpy", "scipy")}
    core = {"core_sha256": hashlib.sha256(library_path().read_bytes()).hexdigest()}
    return results.provenance() | core | versions | table.describe() | dict(options)


@contextmanager
def writer_lock(path: Path) -> Iterator[None]:
    """Sole right to write the store at ``path``; a lock that a dead process left does not count.

    Raises:
        InputError: another process holds it, or the folder cannot be written.
    """
    lock = path.with_name(f".{path.name}.lock")
    descriptor = _locked(lock, path)
    try:
        os.ftruncate(descriptor, 0)
        os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(descriptor)


def _locked(lock: Path, path: Path) -> int:
    while True:
        try:
            lock.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(lock, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise _unwritable(path, error, "choose a folder you may write to") from None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = os.read(descriptor, 200).decode(errors="replace") or "another process"
            os.close(descriptor)
            raise InputError(f"{path} is being written by {holder}; wait until that has ended.") from None
        if lock.exists() and os.path.samestat(os.fstat(descriptor), lock.stat()):
            return descriptor
        os.close(descriptor)  # its last holder has just removed the file


def _unwritable(path: Path, error: OSError, advice: str) -> InputError:
    return InputError(f"Cannot write {path} ({error.strerror or error}); {advice}.")


class CaseStore:
    """A store being filled. Hold `writer_lock` while writing.

    Args:
        path: of the store; made with its first chunk when there is none.
        table: its cases.
        options: further attributes that its values follow from.
        chunk: cases a chunk; default about `chunk_size`.

    Raises:
        InputError: what is at ``path`` is no store, a damaged one, or one of another version or with other options.
    """

    def __init__(self, path: Path, table: CaseTable, options: Mapping[str, Any], chunk: int | None = None):
        self.path, self.table = path, table
        columns = table.columns
        self._schema = {column.name: attributes(column) for column in columns}
        self._schema |= results.schema(tuple(self._schema)) | {FINISHED: (np.dtype(bool), {})}
        self._chunk = chunk or table.block(chunk_size(len(table)))
        self._identity = identity(table, options) | {"chunk": self._chunk}
        is_new = not path.exists() or (path.is_dir() and not any(path.iterdir()))
        self._arrays = None if is_new else self._open()

    def _create(self) -> dict[str, zarr.Array]:
        partial = self.path.with_name(f".{self.path.name}.partial")
        shutil.rmtree(partial, ignore_errors=True)
        title = "Lowest and highest speed of steady manoeuvres of the GTM-T2 with failed controls"
        names = [column.name for column in self.table.columns]
        described_all = {"title": title, "coordinates": " ".join(names), **self._identity}
        group = zarr.create_group(partial, attributes=described_all)
        for name, (dtype, described) in self._schema.items():
            group.create_array(
                name,
                shape=(len(self.table),),
                chunks=(self._chunk,),
                dtype=dtype,
                fill_value=np.nan if dtype.kind == "f" else dtype.type(0),
                compressors=ZstdCodec(level=3, checksum=True),
                dimension_names=("case",),
                attributes=described,
            )
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Consolidated metadata")  # readers ask for it
            zarr.consolidate_metadata(partial)
        os.replace(partial, self.path)
        return self._open()

    def _open(self) -> dict[str, zarr.Array]:
        try:
            stored = dict(zarr.open_group(self.path, mode="r+", use_consolidated=False).attrs)
        except Exception as error:
            raise _unreadable(self.path, error) from None
        self._check_identity(stored)
        try:
            # A chunk without any envelope is written like the others, so that a missing file tells of damage.
            with zarr.config.set({"array.write_empty_chunks": True}):
                arrays = {name: zarr.open_array(self.path / name, mode="r+") for name in self._schema}
        except Exception as error:
            raise _unreadable(self.path, error) from None
        for leftover in self.path.glob("*/c/*.partial"):  # of a writer that was stopped
            leftover.unlink()
        return arrays

    def _check_identity(self, stored: Mapping[str, Any]) -> None:
        if not self._identity.keys() & stored.keys():
            raise _unreadable(self.path, ValueError("a zarr store of another kind"))
        further = (name for name in stored if name.startswith("axis_") and name not in self._identity)
        for name in (*self._identity, *further):
            value = self._identity.get(name)
            if stored.get(name) != value:
                kind = "by another version" if name.endswith(("_version", "_sha256")) else "with other options"
                change = f"{name}: {stored.get(name)!s:.60}, now {value!s:.60}"
                raise InputError(
                    f"{self.path} was made {kind} ({change}) and was left as it is; choose another folder, or remove "
                    "that one."
                )

    def unfinished(self) -> list[range]:
        """Cases of every chunk that is still to be computed, also of one of which a file was removed."""
        starts = range(0, len(self.table), self._chunk)
        chunks = [range(start, min(start + self._chunk, len(self.table))) for start in starts]
        if self._arrays is None:
            return chunks
        try:
            finished = np.asarray(self._arrays[FINISHED][:])
        except Exception as error:
            raise _unreadable(self.path, error) from None
        return [cases for k, cases in enumerate(chunks) if not (finished[cases.start] and self._complete(k))]

    def _complete(self, k: int) -> bool:
        return all((self.path / name / "c" / str(k)).exists() for name in self._schema)

    def write(self, cases: range, found: Mapping[str, np.ndarray]) -> None:
        """Write the inputs and the results of a whole chunk, and last that it is finished.

        Raises:
            InputError: the folder cannot be written, or the disk is full.
        """
        inputs = self.table.rows(cases.start, cases.stop).T
        columns = dict(zip((column.name for column in self.table.columns), inputs, strict=True)) | dict(found)
        columns[FINISHED] = np.ones(len(cases), dtype=bool)
        try:
            self._arrays = self._arrays or self._create()
            for name, values in columns.items():
                self._arrays[name][cases.start : cases.stop] = values.astype(self._schema[name][0])
        except OSError as error:
            advice = "finished chunks are kept: make room and give the same command again"
            raise _unwritable(self.path, error, advice) from None


def _unreadable(path: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return InputError(f"{path} is no readable data set ({reason}); make a new one elsewhere.")


def open_cases(path: str | Path) -> xr.Dataset:
    """The data set of a store, finished or not, read from disk only where it is looked at.

    Raises:
        InputError: there is none, or it is damaged.
    """
    try:
        data = xr.open_zarr(path, consolidated=False, chunks=None, decode_coords=False)
        inputs = data.attrs.pop("coordinates").split()
        return data[[*inputs, *results.schema(inputs), FINISHED]].set_coords(inputs)
    except Exception as error:
        raise _unreadable(Path(path), error) from None


def slices(path: str | Path, names: Sequence[str] | None = None) -> Iterator[xr.Dataset]:
    """The data set of a store chunk by chunk, in memory; only the variables ``names`` if they are given.

    Raises:
        InputError: there is none, or a chunk is damaged.
    """
    data = open_cases(path)
    step, cases = int(data.attrs["chunk"]), data.sizes["case"]
    for start in range(0, cases, step):
        chunk = data.isel(case=slice(start, start + step))
        try:
            loaded = (chunk if names is None else chunk[list(names)]).load()
        except Exception as error:
            raise InputError(
                f"{path} is damaged at cases {start} to {min(start + step, cases) - 1} ({error}); remove the file "
                f"finished/c/{start // step} from it and give the command that made it again."
            ) from None
        yield loaded
