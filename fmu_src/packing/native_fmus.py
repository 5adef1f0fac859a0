"""Building a native FMU: sources, binaries, documentation, expected results."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path

from fmu_src.description.documentation import PROJECT, documentation
from fmu_src.description.dynamics_variables import dynamics_description
from fmu_src.description.fmi2_xml import write_fmi2
from fmu_src.description.fmi3_xml import write_build_description, write_fmi3, write_terminals_and_icons
from fmu_src.description.icon import icon_png
from fmu_src.description.model_description import ModelDescription, Variable
from fmu_src.description.native_variables import (
    DYNAMICS_FAULTS,
    DYNAMICS_USAGE,
    STARTS_USAGE,
    TOLERANCE,
    native_description,
    start_parameters,
)
from fmu_src.description.reference_results import (
    reference_envelopes,
    reference_failures,
    reference_flight,
    reference_manoeuvres,
    reference_simulation,
)
from fmu_src.packing.archive import content_id
from fmu_src.packing.compiler import Platform, all_binaries, host_binary
from fmu_src.packing.native_sources import header_licence, source_files, standard_headers, variable_table, with_prefix
from fmu_src.slaves.gtm_aircraft import ALL_FAULTS
from gtm_fmu.core import followed
from gtm_fmu.core.simulation import memory_size
from gtm_fmu.core.sources import DYNAMICS, THRUST_MAP, WHOLE
from gtm_fmu.errors import InputError
from surrogate.exports.closed_form import closed_form
from surrogate.exports.forms import export_c

SHARED = (
    "model.h",
    "instance.h",
    "internal.h",
    "instance.c",
    "values.c",
    "evaluation.c",
    "fmu_state.c",
)
WRITERS = {2: write_fmi2, 3: write_fmi3}


@dataclass(frozen=True)
class NativeContents:
    """What makes one native FMU: description, sentences of its faults, C files, files of its own."""

    model: ModelDescription
    faults: tuple[str, ...]
    sources: dict[str, bytes]
    extra: dict[str, bytes]

    def token(self) -> str:
        """GUID or instantiation token: that of everything but the binaries, which depend on the compiler."""
        description = {"xml": self._description("")}
        return content_id(self.sources | variable_table(self.model, self.faults, "") | self.extra | description)

    def all_sources(self) -> dict[str, bytes]:
        """The C files of a shared library, with the standard's headers."""
        return self._own_sources() | standard_headers(self.model.implementation.fmi)

    def shipped_sources(self) -> dict[str, bytes]:
        """The C files of the folder ``sources``: with a prefix, and without the headers, which are the importer's."""
        return with_prefix(self._own_sources(), self.model.name, self.model.implementation.fmi)

    def _own_sources(self) -> dict[str, bytes]:
        return self.sources | variable_table(self.model, self.faults, self.token())

    def members(self, all_platforms: bool, progress: Callable[[int, int], None] | None = None) -> dict[str, bytes]:
        """Files of the FMU by their paths."""
        model, fmi, sources = self.model, self.model.implementation.fmi, self.all_sources()
        built = all_binaries(model.name, sources, fmi, progress) if all_platforms else host_binary(model.name, sources)
        members = {f"sources/{path}": content for path, content in self.shipped_sources().items()} | self.extra
        members |= {_binary_path(platform, model.name, fmi): content for platform, content in built.items()}
        platforms = [platform.folder(fmi) or "" for platform in built]
        licences = {"FMI-headers-LICENSE.txt": header_licence()}
        pages = documentation(model, platforms, licences)
        members |= {f"documentation/{path}": content for path, content in pages.items()}
        if fmi == 2:
            members["model.png"] = icon_png()
        else:
            members["sources/buildDescription.xml"] = write_build_description(model)
            members["terminalsAndIcons/terminalsAndIcons.xml"] = write_terminals_and_icons()
            members["terminalsAndIcons/icon.png"] = icon_png()
        return members | {"modelDescription.xml": self._description(self.token())}

    def _description(self, token: str) -> bytes:
        return WRITERS[self.model.implementation.fmi](self.model, token, version(PROJECT))


def _binary_path(platform: Platform, name: str, fmi: int) -> str:
    return f"binaries/{platform.folder(fmi)}/{name}{platform.suffix}"


@dataclass(frozen=True)
class NativeModel:
    """A model as the wrappers take it: sentences of its faults, its C files, what it adds to its pythonfmu sibling."""

    faults: tuple[str, ...]
    native: tuple[str, ...]
    """Its files in the folder ``native``."""
    core: tuple[str, ...] = ()
    """C files of the core."""
    written: Mapping[str, bytes] = field(default_factory=dict)
    """C files that are written for it."""
    usage: tuple[str, ...] = ()
    groups: Mapping[str, tuple[Variable, ...]] = field(default_factory=dict)
    later: tuple[str, ...] = ()
    """Groups that come after the time."""
    has_partial_derivatives: bool = False
    memory: int = 0
    has_model_exchange: bool = True
    defers: bool = False
    """Whether it computes deferred outputs."""

    def contents(
        self, sibling: ModelDescription, fmi: int, reference: Callable[[ModelDescription], dict[str, bytes]]
    ) -> NativeContents:
        """The FMU of FMI 2.0 or 3.0; ``reference`` makes its expected results."""
        derivatives = f"{'' if self.has_partial_derivatives else 'no_'}partial_derivatives.c"
        nothing = () if self.defers else ("nothing_deferred.c",)
        sources = source_files((*SHARED, derivatives, *nothing, *self.native), self.core, fmi) | dict(self.written)
        to_compile = tuple(sorted(name for name in (*sources, "variables.c") if name.endswith(".c")))
        added = self.usage, self.groups, self.later, self.has_partial_derivatives, self.memory, self.has_model_exchange
        name = sibling.name if sibling.origin else f"{sibling.name}Native{'' if fmi == 2 else fmi}"
        model = native_description(sibling, name, fmi, to_compile, *added)
        return NativeContents(model, self.faults, sources, reference(model))


def refuse_networks(name: str, networks: Sequence[Path]) -> None:
    """Refuse networks for an FMU without any.

    Raises:
        InputError: some were given.
    """
    if networks:
        raise InputError(f"Networks were given for the {name} FMU, which uses none: leave them out.")


def dynamics_contents(fmi: int, networks: Sequence[Path]) -> NativeContents:
    """GtmDynamicsNative in FMI 2.0 or GtmDynamicsNative3 in FMI 3.0."""
    refuse_networks("dynamics", networks)
    model = dynamics_description()
    native = NativeModel(
        faults=DYNAMICS_FAULTS,
        native=("dynamics.c", "dormand_prince.h", "dormand_prince.c"),
        core=DYNAMICS,
        usage=(*DYNAMICS_USAGE, *STARTS_USAGE),
        groups={
            "solver": (*model.groups["solver"], TOLERANCE),
            "start": start_parameters(model.groups["states"]),
        },
        has_partial_derivatives=True,
    )
    return native.contents(model, fmi, reference_flight)


def envelope_contents(fmi: int, networks: Sequence[Path]) -> NativeContents:
    """GtmEnvelopeNative in FMI 2.0 or GtmEnvelopeNative3 in FMI 3.0."""
    from fmu_src.description.envelope_variables import MEMORY, envelope_description
    from fmu_src.description.failure_variables import SLOPES_USAGE
    from fmu_src.slaves.failure_faults import FAILURE_FAULTS

    refuse_networks("envelope", networks)
    native = NativeModel(
        faults=FAILURE_FAULTS,
        native=("envelope_model.c", "stateless.c"),
        core=WHOLE,
        later=("failure",),
        memory=MEMORY + followed.memory_size(),
        usage=(SLOPES_USAGE,),
        has_partial_derivatives=True,
    )
    return native.contents(envelope_description(), fmi, reference_failures)


def manoeuvre_contents(fmi: int, networks: Sequence[Path]) -> NativeContents:
    """GtmManoeuvreNative in FMI 2.0 or GtmManoeuvreNative3 in FMI 3.0."""
    from fmu_src.description.failure_variables import SLOPES_USAGE
    from fmu_src.description.manoeuvre_variables import manoeuvre_description
    from fmu_src.slaves.failure_faults import FAILURE_FAULTS

    refuse_networks("manoeuvre", networks)
    native = NativeModel(
        faults=FAILURE_FAULTS,
        native=("manoeuvre_model.c", "stateless.c"),
        core=WHOLE,
        usage=(SLOPES_USAGE,),
        has_partial_derivatives=True,
        defers=True,
    )
    return native.contents(manoeuvre_description(), fmi, reference_manoeuvres)


def surrogate_contents(fmi: int, networks: Sequence[Path]) -> NativeContents:
    """GtmSurrogateNative in FMI 2.0 or GtmSurrogateNative3 in FMI 3.0: by a thrust map, or by two networks."""
    from fmu_src.description.envelope_variables import ENVELOPE_FAULTS
    from fmu_src.description.surrogate_variables import (
        DEFERRED_ENVELOPE,
        NATIVE_USAGE,
        emulated_envelope,
        read_networks,
        surrogate_description,
    )

    if is_map(networks):
        return _mapped(fmi, networks, "GtmSurrogate", only="rudder")
    speeds, throttle = read_networks(networks)
    native = NativeModel(
        faults=ENVELOPE_FAULTS,
        native=("surrogate_model.c", "stateless.c"),
        written=export_c(closed_form(speeds, has_short_factor=True), "speeds")
        | export_c(closed_form(throttle, has_std=False), "throttle"),
        usage=NATIVE_USAGE,
        groups={"envelope": DEFERRED_ENVELOPE},
        has_partial_derivatives=True,
        defers=True,
    )
    reference = partial(reference_envelopes, find=emulated_envelope(speeds, throttle))
    return native.contents(surrogate_description(speeds, throttle), fmi, reference)


def thrust_map_contents(fmi: int, networks: Sequence[Path]) -> NativeContents:
    """GtmThrustMapNative in FMI 2.0 or GtmThrustMapNative3 in FMI 3.0, with a map of any control; default the rudder's.

    That of another control is named after it, as GtmThrustMapElevatorNative.
    """
    if not is_map(networks):
        refuse_networks("thrust map", networks)
    return _mapped(fmi, networks)


def is_map(files: Sequence[Path]) -> bool:
    """Whether the files of a surrogate are a thrust map, or none, which is the map of the package; else networks."""
    return len(files) < 2


def _mapped(fmi: int, files: Sequence[Path], name: str | None = None, only: str | None = None) -> NativeContents:
    from fmu_src.description.map_variables import (
        map_faults,
        map_reference,
        map_source,
        read_map,
        thrust_map_description,
    )

    thrust_map = read_map(next(iter(files), None), only)
    native = NativeModel(
        faults=map_faults(thrust_map),
        native=("map_model.c", "stateless.c"),
        core=THRUST_MAP,
        written=map_source(thrust_map),
    )
    return native.contents(thrust_map_description(thrust_map, name), fmi, map_reference(thrust_map))


def aircraft_contents(fmi: int, networks: Sequence[Path]) -> NativeContents:
    """GtmAircraftNative in FMI 2.0 or GtmAircraftNative3 in FMI 3.0."""
    from fmu_src.description.aircraft_variables import aircraft_description

    refuse_networks("aircraft", networks)
    model = aircraft_description()
    native = NativeModel(
        faults=("", *ALL_FAULTS.values()),
        native=("aircraft.c",),
        core=WHOLE,
        memory=memory_size(),
        has_model_exchange=False,
        usage=STARTS_USAGE,
        groups={"start": start_parameters(model.groups["states"])},
    )
    return native.contents(model, fmi, reference_simulation)


_MAKERS = {
    "dynamics": dynamics_contents,
    "aircraft": aircraft_contents,
    "envelope": envelope_contents,
    "manoeuvre": manoeuvre_contents,
    "surrogate": surrogate_contents,
    "thrust-map": thrust_map_contents,
}
NATIVE_MODELS: dict[str, Callable[[Sequence[Path]], NativeContents]] = {
    f"{name}-native{'' if fmi == 2 else fmi}": partial(make, fmi) for name, make in _MAKERS.items() for fmi in (2, 3)
}
"""The native FMUs by their short names: FMI 2.0, and FMI 3.0."""
