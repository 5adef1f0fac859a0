"""The zarr store of a data set, filled chunk by chunk.

Every input and result is an array over ``case``. A chunk is a slice of all of them; its files are each written in one
piece, and ``finished`` last. So a store that was left at any moment holds whole chunks and knows which. ``checksum``
binds the values of a case to each other and to its place, so that a chunk that was lost, changed or put in the place of
another is noticed, and computed again.
"""

import fcntl
import hashlib
import os
import shutil
import socket
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from zarr.codecs import ZstdCodec

from gtm_fmu.aircraft.inputs import attributes
from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.core import library_path
from gtm_fmu.datasets import results
from gtm_fmu.datasets.cases import Cases
from gtm_fmu.errors import InputError
from gtm_fmu.files import real_path

FINISHED, CHECKSUM = "finished", "checksum"
TOLERANCES = "tolerances"
"""The option with which a store holds guaranteed and possible speeds too."""
METADATA, LOCK, NEW = "zarr.json", ".gtm-fmu.lock", ".gtm-fmu.new"
_MAKE_ROOM = "finished chunks are kept: make room and give the same command again"
SMALLEST_CHUNK, LARGEST_CHUNK = 64, 1024
"""Cases; in between some 64 chunks a store."""


def chunk_size(cases: int) -> int:
    """Cases a chunk of a store of that size."""
    power_of_two = 1 << (cases // 64).bit_length()
    return min(max(power_of_two, SMALLEST_CHUNK), LARGEST_CHUNK)


def identity(table: Cases, options: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes that tell what the values of a store follow from; a store is only continued if all are the same."""
    versions = {f"{package}_version": version(package) for package in ("numpy", "scipy")} | {"store_version": "2"}
    core = {"core_sha256": hashlib.sha256(library_path().read_bytes()).hexdigest()}
    return provenance() | core | versions | table.describe() | dict(options)


@contextmanager
def writer_lock(path: Path) -> Iterator[None]:
    """Sole right to write the store at ``path``, under all its names; a lock that a dead process left does not count.

    Raises:
        InputError: another process holds it, something else than a store is there, or the folder cannot be written.
    """
    place = real_path(path)
    try:
        is_new = not place.exists()
        if not (is_new or (place / METADATA).is_file() or _is_begun(place)):
            raise _unreadable(path, ValueError("no store of a data set"))
    except OSError as error:
        raise _unwritable(path, error, "choose a folder you may write to") from None
    lock = place / LOCK
    descriptor = _locked(lock, path)
    try:
        try:
            os.ftruncate(descriptor, 0)
            os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
        except OSError as error:
            raise _unwritable(path, error, _MAKE_ROOM) from None
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(descriptor)
        if is_new:
            with suppress(OSError):  # nothing was written
                place.rmdir()


def _locked(lock: Path, path: Path) -> int:
    while True:
        try:
            lock.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
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


def _is_begun(path: Path) -> bool:
    """Whether a folder is empty, or holds what a writer left that was stopped before the metadata, which come last."""
    names = os.listdir(path) if path.is_dir() else [METADATA]
    return METADATA not in names and (not names or LOCK in names)


def _unwritable(path: Path, error: OSError, advice: str) -> InputError:
    return InputError(f"Cannot write {path} ({error.strerror or error}); {advice}.")


class OtherStoreError(InputError):
    """A store of another version, or with other options."""


class CaseStore:
    """A store being filled. Hold `writer_lock` while writing.

    Args:
        path: of the store; made with its first chunk when there is none.
        table: its cases.
        options: further attributes that its values follow from.
        chunk: cases a chunk; default about `chunk_size`.
        replace: begin anew where a store of another version or with other options is.

    Raises:
        InputError: what is at ``path`` is no store, a damaged one, or one of another version or with other options.
    """

    def __init__(
        self, path: Path, table: Cases, options: Mapping[str, Any], chunk: int | None = None, replace: bool = False
    ):
        self.path, self.table = path, table
        columns = table.columns
        self._schema = {column.name: attributes(column) for column in columns}
        self._schema |= results.schema(tuple(self._schema), TOLERANCES in options)
        self._schema |= {CHECKSUM: (np.dtype(np.uint64), {}), FINISHED: (np.dtype(bool), {})}
        self._chunk = chunk or table.block(chunk_size(len(table)))
        self._identity = identity(table, options) | {"chunk": self._chunk}
        try:
            self._arrays = None if not path.exists() or _is_begun(path) else self._open()
        except OtherStoreError:
            if not replace:
                raise
            self._clear()
            self._arrays = None

    def _clear(self) -> None:
        """Remove what is in the store but for the writer's lock; its metadata go first, so that a rest is no store."""
        (self.path / METADATA).unlink()
        for entry in self.path.iterdir():
            if entry.is_dir():
                shutil.rmtree(entry)
            elif entry.name != LOCK:
                entry.unlink()

    def _create(self) -> dict[str, zarr.Array]:
        title = "Lowest and highest speed of steady manoeuvres of the GTM-T2 with failed controls"
        names = [column.name for column in self.table.columns]
        described_all = {"title": title, "coordinates": " ".join(names), **self._identity}
        new = self.path / NEW
        try:
            self._describe(new, described_all)
            for file in sorted(new.rglob(METADATA), key=lambda file: -len(file.parts)):  # the group's is last
                place = self.path / file.relative_to(new)
                place.parent.mkdir(exist_ok=True)
                os.replace(file, place)
        finally:
            shutil.rmtree(new, ignore_errors=True)
        return self._open()

    def _describe(self, folder: Path, described_all: dict[str, Any]) -> None:
        shutil.rmtree(folder, ignore_errors=True)  # of a writer that was stopped
        group = zarr.create_group(folder, attributes=described_all)
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
            zarr.consolidate_metadata(folder)

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
        shutil.rmtree(self.path / NEW, ignore_errors=True)
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
                raise OtherStoreError(
                    f"{self.path} was made {kind} ({change}) and was left as it is; choose another folder, or remove "
                    "that one."
                )

    def unfinished(self) -> list[range]:
        """Cases of every chunk that is still to be computed, also of one that was damaged, or lost a file.

        Raises:
            InputError: the store cannot be read, or a folder lies in the place of a chunk.
        """
        starts = range(0, len(self.table), self._chunk)
        chunks = [range(start, min(start + self._chunk, len(self.table))) for start in starts]
        if self._arrays is None:
            return chunks
        return [cases for k, cases in enumerate(chunks) if not (self._complete(k) and self._holds(cases))]

    def _complete(self, k: int) -> bool:
        files = [self.path / name / "c" / str(k) for name in self._schema]
        if folder := next((file for file in files if file.is_dir()), None):
            raise InputError(f"{folder} is a folder in the place of a chunk; remove it and give the command again.")
        return all(file.is_file() for file in files)

    def _holds(self, cases: range) -> bool:
        """Whether a chunk is finished and holds what was written."""
        assert self._arrays is not None
        try:
            columns = {name: np.asarray(array[cases.start : cases.stop]) for name, array in self._arrays.items()}
        except OSError as error:
            raise _unreadable(self.path, error) from None
        except Exception:  # of a chunk that is damaged, codecs raise errors of all kinds
            return False
        return bool(columns.pop(FINISHED).all()) and not _damaged(columns, cases.start).any()

    def write(self, cases: range, found: Mapping[str, np.ndarray]) -> None:
        """Write the inputs and the results of a whole chunk, and last that it is finished.

        Raises:
            InputError: the folder cannot be written, or the disk is full.
        """
        inputs = self.table.rows(cases.start, cases.stop).T
        columns = dict(zip((column.name for column in self.table.columns), inputs, strict=True)) | dict(found)
        columns = {name: values.astype(self._schema[name][0]) for name, values in columns.items()}
        columns[CHECKSUM] = _checksums(columns, cases.start)
        columns[FINISHED] = np.ones(len(cases), dtype=bool)
        try:
            self._arrays = self._arrays or self._create()
            for name, values in columns.items():
                self._arrays[name][cases.start : cases.stop] = values
        except OSError as error:
            raise _unwritable(self.path, error, _MAKE_ROOM) from None


def _checksums(columns: Mapping[str, np.ndarray], start: int) -> np.ndarray:
    """A number for each case (n) of its place in the data set and all its values."""
    count = len(next(iter(columns.values())))
    numbered = {"": np.arange(start, start + count)} | dict(sorted(columns.items()))
    rows = np.hstack([_bytes(values) for values in numbered.values()])
    digests = b"".join(hashlib.blake2b(row, digest_size=8).digest() for row in rows)
    return np.frombuffer(digests, dtype="<u8").astype(np.uint64)


def _bytes(values: np.ndarray) -> np.ndarray:
    """Values as bytes (n, size), the same on every machine; one NaN is as good as another."""
    if values.dtype.kind == "f":
        values = np.where(np.isnan(values), np.nan, values)
    little_endian = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return little_endian.view(np.uint8).reshape(len(values), -1)


def _damaged(columns: Mapping[str, np.ndarray], start: int) -> np.ndarray:
    """Which cases (n) do not hold what was written."""
    values = dict(columns)
    return values.pop(CHECKSUM) != _checksums(values, start)


def _unreadable(path: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return InputError(f"{path} is no readable data set ({reason}); make a new one elsewhere.")


def open_cases(path: str | Path) -> xr.Dataset:
    """The data set of a store, finished or not, read from disk only where it is looked at; `slices` finds damage.

    Raises:
        InputError: there is none, or its metadata are damaged.
    """
    return _open_all(path).drop_vars(CHECKSUM)


def _open_all(path: str | Path) -> xr.Dataset:
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=rf"Object at {LOCK}")  # it is being written
            data = xr.open_zarr(path, consolidated=False, chunks=None, decode_coords=False)
        inputs = data.attrs.pop("coordinates").split()
        return data[[*inputs, *results.schema(inputs, TOLERANCES in data.attrs), CHECKSUM, FINISHED]].set_coords(inputs)
    except Exception as error:
        raise _unreadable(Path(path), error) from None


def slices(path: str | Path, names: Sequence[str] | None = None) -> Iterator[xr.Dataset]:
    """The data set of a store chunk by chunk, in memory; only the variables ``names`` if they are given.

    Raises:
        InputError: there is none, or a chunk is damaged, of whichever variable.
    """
    data = _open_all(path)
    step, cases = int(data.attrs["chunk"]), data.sizes["case"]
    for start in range(0, cases, step):
        try:
            chunk = data.isel(case=slice(start, start + step)).load()
            columns = {str(name): values.values for name, values in chunk.variables.items() if name != FINISHED}
            if (chunk[FINISHED].values & _damaged(columns, start)).any():
                raise ValueError("the values are not those that were written")
        except Exception as error:
            raise InputError(
                f"{path} is damaged at cases {start} to {min(start + step, cases) - 1} ({error}); give the command "
                "that made it again, which computes them anew."
            ) from None
        yield chunk.drop_vars(CHECKSUM) if names is None else chunk[list(names)]
