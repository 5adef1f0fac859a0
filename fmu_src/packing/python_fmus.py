"""Building an FMU: pythonfmu packs the slave, then the archive is repacked so that equal contents give equal bytes.

All slaves of a process share its modules, so the code of an FMU lies in a package named by a hash of its contents:
two FMUs, or an old and a rebuilt one, never run each other's code.

The binary is the wrapper in ``python_wrapper``, compiled for this platform; for Windows it is pythonfmu's own.
"""

import sys
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from json import dumps
from pathlib import Path

from pythonfmu import FmuBuilder

from fmu_src.description.documentation import PROJECT, documentation, legal_texts
from fmu_src.description.dynamics_variables import dynamics_description
from fmu_src.description.fmi2_xml import write_fmi2
from fmu_src.description.icon import icon_png
from fmu_src.description.model_description import ModelDescription, slave_table
from fmu_src.packing.archive import content_id, digest, write_archive
from fmu_src.packing.compiler import host_binary
from fmu_src.packing.native_fmus import NATIVE_MODELS, is_map, refuse_networks
from fmu_src.packing.native_sources import CORE, standard_headers
from fmu_src.slaves.slave import TABLE_FILE, platform_folder
from gtm_fmu.core import library_path
from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable, temporary_folder, writable_folder
from surrogate.exports.closed_form import closed_form
from surrogate.exports.forms import json_text

SOURCES = Path(__file__).parents[1]
WRAPPER = "python_wrapper"
PYTHONFMU_PLATFORM = "win64"
"""Where the binary is pythonfmu's own."""
ENTRY = '''"""Entry point for pythonfmu, whose binary runs it at each instantiation; the code is in the package."""

import ctypes

from {package}.{module} import {slave}

# pythonfmu 0.7.0 gives back one reference too many to this module's dictionary each time.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
'''


@dataclass(frozen=True)
class Contents:
    """What makes one FMU: description, modules of the slave (which is in the last), resources, where it runs."""

    model: ModelDescription
    modules: tuple[str, ...]
    resources: dict[str, bytes]
    platforms: list[str]

    @property
    def _own_resources(self) -> dict[str, bytes]:
        return {**self.resources, TABLE_FILE: dumps(slave_table(self.model), indent=1).encode()}

    @property
    def _code(self) -> dict[str, bytes]:
        return {f"{name}.py": _source(name).read_bytes() for name in self.modules}

    @cached_property
    def package(self) -> str:
        """Name of the package that holds the code."""
        return f"{self.modules[-1]}_{digest(self._own_resources | self._code)[:16]}"

    def files(self) -> dict[str, bytes]:
        """Files under ``resources`` by their path, the slave's package with its entry point included."""
        entry = ENTRY.format(package=self.package, module=self.modules[-1], slave=self.model.name)
        return {
            f"{self.package}_entry.py": entry.encode(),
            f"{self.package}/__init__.py": b'"""The code of one FMU."""\n',
            **{f"{self.package}/{name}": source for name, source in self._code.items()},
            **self._own_resources,
        }

    def wrapper_sources(self, guid: str) -> dict[str, bytes]:
        """C files of the binary by their names, with the names of slave and module and the GUID that it asks for."""
        names = {"GUID": guid, "MODULE": f"{self.package}.{self.modules[-1]}", "CLASS": self.model.name}
        header = "".join(f'#define SLAVE_{name} "{value}"\n' for name, value in names.items())
        files = {path.name: path.read_bytes() for path in sorted((SOURCES / WRAPPER).glob("*.[ch]"))}
        return files | standard_headers(2) | {"fmu.h": header.encode()}


def _source(module: str) -> Path:
    """A module that runs inside FMUs: a slave, or of the core or of the airframe."""
    folders = SOURCES / "slaves", CORE, CORE.parent / "airframe"
    return next(path for folder in folders if (path := folder / f"{module}.py").exists())


def dynamics_contents(networks: Sequence[Path]) -> Contents:
    """GtmDynamics."""
    refuse_networks("dynamics", networks)
    return _with_core(dynamics_description(), "gtm_dynamics")


def aircraft_contents(networks: Sequence[Path]) -> Contents:
    """GtmAircraft."""
    from fmu_src.description.aircraft_variables import aircraft_description

    refuse_networks("aircraft", networks)
    return _with_core(aircraft_description(), "gtm_dynamics", "gtm_aircraft")


def envelope_contents(networks: Sequence[Path]) -> Contents:
    """GtmEnvelope."""
    from fmu_src.description.envelope_variables import envelope_description

    refuse_networks("envelope", networks)
    return _with_core(envelope_description(), "names", "failure_faults", "envelope_slave", "gtm_envelope")


def manoeuvre_contents(networks: Sequence[Path]) -> Contents:
    """GtmManoeuvre."""
    from fmu_src.description.manoeuvre_variables import manoeuvre_description

    refuse_networks("manoeuvre", networks)
    return _with_core(manoeuvre_description(), "failure_faults", "gtm_manoeuvre")


def _with_core(model: ModelDescription, *modules: str) -> Contents:
    """An FMU that carries the compiled core of this platform."""
    try:
        core = library_path()
    except FileNotFoundError as error:
        raise InputError(str(error)) from error
    here = platform_folder()
    resources = {f"core/{here}/{core.name}": core.read_bytes()}
    return Contents(model, ("slave", "core_library", *modules), resources, [here])


def surrogate_contents(networks: Sequence[Path]) -> Contents:
    """GtmSurrogate: a thrust map in the core of this platform; or the network of V_min and V_max, and that of t_min, in
    pure Python, so for Windows too.
    """
    if is_map(networks):
        from fmu_src.description.map_variables import map_resources, read_map, thrust_map_description

        thrust_map = read_map(next(iter(networks), None), only="rudder")
        modules = ("map_layout", "envelope_slave", "mapped_surrogate")
        found = _with_core(thrust_map_description(thrust_map, "GtmSurrogate"), *modules)
        return replace(found, resources=found.resources | map_resources(thrust_map))
    from fmu_src.description.surrogate_variables import NETWORKS, read_networks, surrogate_description

    speeds, throttle = read_networks(networks)
    forms = closed_form(speeds), closed_form(throttle, has_std=False)
    resources = {f"{name}.json": json_text(form).encode() for name, form in zip(NETWORKS, forms, strict=True)}
    model = surrogate_description(speeds, throttle)
    platforms = sorted({platform_folder(), PYTHONFMU_PLATFORM})
    return Contents(model, ("slave", "closed_form", "envelope_slave", "gtm_surrogate"), resources, platforms)


MODELS: dict[str, Callable[[Sequence[Path]], Contents]] = {
    "dynamics": dynamics_contents,
    "aircraft": aircraft_contents,
    "envelope": envelope_contents,
    "manoeuvre": manoeuvre_contents,
    "surrogate": surrogate_contents,
}
"""The FMUs of pythonfmu by their short names."""


def build(
    name: str,
    destination: str | Path = ".",
    networks: Sequence[str | Path] = (),
    all_platforms: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Build an FMU into a folder; equal sources give equal bytes.

    Args:
        name: a key of `MODELS` or of `NATIVE_MODELS`.
        destination: folder of the FMU; made when missing.
        networks: for a surrogate, the files of two trained networks or the one of a thrust map; without any the
            thrust map that comes with the package.
        all_platforms: for a native FMU, binaries for all platforms by Zig, not only for this one.
        progress: called with the number of platforms that are finished and of all.

    Returns:
        Path of the FMU, named after its model.

    Raises:
        InputError: an unknown name, a missing core, network or compiler, a platform that is not served, or a folder
            that cannot be written.
    """
    given = [Path(network) for network in networks]
    if name in NATIVE_MODELS:
        native = NATIVE_MODELS[name](given)
        path = _place(destination, native.model)
        return write_archive(path, native.members(all_platforms, progress))
    if name not in MODELS:
        raise InputError(f"No FMU is called '{name}': choose one of {', '.join((*MODELS, *NATIVE_MODELS))}.")
    if all_platforms:
        raise InputError(f"The FMU {name} runs in Python: only native ones are built for all platforms.")
    contents = MODELS[name](given)
    path = _place(destination, contents.model)
    members = _packed(contents)
    pages = documentation(contents.model, contents.platforms, legal_texts("pythonfmu"))
    members |= {f"documentation/{path}": text for path, text in pages.items()}
    members["model.png"] = icon_png()
    members["modelDescription.xml"] = write_fmi2(contents.model, "", version(PROJECT))
    guid = content_id(members | contents.wrapper_sources(""))
    members["modelDescription.xml"] = write_fmi2(contents.model, guid, version(PROJECT))
    if (here := platform_folder()) != PYTHONFMU_PLATFORM:
        ((platform, binary),) = host_binary(contents.model.name, contents.wrapper_sources(guid), ["-ldl"]).items()
        members[f"binaries/{here}/{contents.model.name}{platform.suffix}"] = binary
    return write_archive(path, members)


def _place(destination: str | Path, model: ModelDescription) -> Path:
    """The file of an FMU, its folder made; refused before the work where it cannot be written."""
    return check_writable(writable_folder(destination) / f"{model.name}.fmu")


def _packed(contents: Contents) -> dict[str, bytes]:
    """What pythonfmu makes: resources with its own code, and its binary for the platform that runs it."""
    with temporary_folder() as folder, _import_state_kept():
        source, packed = folder / "source", folder / "packed.fmu"
        for path, content in contents.files().items():
            source.joinpath(path).parent.mkdir(parents=True, exist_ok=True)
            source.joinpath(path).write_bytes(content)
        entry = next(source.glob("*_entry.py"))
        FmuBuilder.build_FMU(entry, packed, project_files=[path for path in source.iterdir() if path != entry])
        with zipfile.ZipFile(packed) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    binaries = f"binaries/{PYTHONFMU_PLATFORM}/" if PYTHONFMU_PLATFORM in contents.platforms else "resources/"
    kept = ("resources/", binaries)
    return {name: content for name, content in members.items() if name.startswith(kept) and "__pycache__" not in name}


@contextmanager
def _import_state_kept() -> Iterator[None]:
    """Undo what pythonfmu's trial import of the slave leaves in this process."""
    search_path, modules = list(sys.path), set(sys.modules)
    try:
        yield
    finally:
        sys.path[:] = search_path
        for module in [name for name in sys.modules if name not in modules and name.startswith("gtm_")]:
            del sys.modules[module]
