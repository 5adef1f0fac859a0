"""Building a native FMU: sources, binaries, documentation, expected results."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version

from fmu_src.archive import content_id
from fmu_src.compiler import Platform, all_binaries, host_binary
from fmu_src.description import ModelDescription
from fmu_src.documentation import PROJECT, documentation
from fmu_src.fmi2_xml import write_fmi2
from fmu_src.fmi3_xml import write_build_description, write_fmi3, write_terminals_and_icons
from fmu_src.icon import icon_png
from fmu_src.native_sources import header_licence, source_files, variable_table
from fmu_src.native_variables import DYNAMICS_FAULTS, native_dynamics_description
from fmu_src.reference_results import reference_files

SHARED = (
    "model.h",
    "instance.h",
    "internal.h",
    "instance.c",
    "values.c",
    "evaluation.c",
    "partial_derivatives.c",
    "fmu_state.c",
)
_MOTION = ("motion.c", "table.c", "generated/airframe.c", "generated/tables.c")
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
        """The C files with the table of variables."""
        return self.sources | variable_table(self.model, self.faults, self.token())

    def members(self, all_platforms: bool) -> dict[str, bytes]:
        """Files of the FMU by their paths."""
        model, fmi, sources = self.model, self.model.implementation.fmi, self.all_sources()
        built = all_binaries(model.name, sources, fmi) if all_platforms else host_binary(model.name, sources)
        members = {f"sources/{path}": content for path, content in sources.items()} | self.extra
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


def dynamics_contents(fmi: int) -> NativeContents:
    """GtmDynamicsNative in FMI 2.0 or GtmDynamicsNative3 in FMI 3.0."""
    sources = source_files((*SHARED, "dynamics.c", "dormand_prince.h", "dormand_prince.c"), _MOTION, fmi)
    to_compile = tuple(sorted(name for name in (*sources, "variables.c") if name.endswith(".c")))
    model = native_dynamics_description(fmi, to_compile)
    return NativeContents(model, DYNAMICS_FAULTS, sources, reference_files(model))


NATIVE_MODELS: dict[str, Callable[[], NativeContents]] = {
    "dynamics-native": lambda: dynamics_contents(2),
    "dynamics-native3": lambda: dynamics_contents(3),
}
"""The native FMUs by their short names: FMI 2.0, and FMI 3.0."""
