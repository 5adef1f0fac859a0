"""Build step of the compiled core: generate its C from the airframe, compile it into one plain shared library."""

import sys
from functools import cache
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
CORE = ROOT / "gtm_fmu" / "core"
C_FLAGS = ["-std=c99", "-O3", "-fno-math-errno", "-g0", "-fvisibility=hidden"]
LIBRARY_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


@cache
def generate_sources() -> None:
    sys.path.insert(0, str(ROOT))
    from gtm_fmu.core.generate import generate

    generate(CORE / "generated")


class BuildPackages(build_py):
    """The generated C comes with the package too: native FMUs are built from it."""

    def run(self):
        generate_sources()
        super().run()


class BuildCore(build_ext):
    """A shared library that no Python is linked into: FMUs load it with ctypes from any host."""

    def run(self):
        generate_sources()
        super().run()

    def build_extensions(self):
        # Python's own link flags may carry a library path of this machine; the library travels in FMUs.
        linker = getattr(self.compiler, "linker_so", None)
        if linker:
            self.compiler.linker_so = [flag for flag in linker if not flag.startswith(("-L", "-Wl,-rpath"))]
        super().build_extensions()

    def get_ext_filename(self, fullname):
        return str(Path(*fullname.split("."))) + LIBRARY_SUFFIX

    def get_export_symbols(self, ext):
        return []


class PlatformWheel(bdist_wheel):
    """The library depends on the platform but not on the Python version."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


setup(
    ext_modules=[
        Extension(
            "gtm_fmu.core.gtm_core",
            sources=[
                "gtm_fmu/core/motion.c",
                "gtm_fmu/core/table.c",
                "gtm_fmu/core/condition.c",
                "gtm_fmu/core/problem.c",
                "gtm_fmu/core/cell.c",
                "gtm_fmu/core/trim.c",
                "gtm_fmu/core/manifold.c",
                "gtm_fmu/core/step.c",
                "gtm_fmu/core/descent.c",
                "gtm_fmu/core/linear_program.c",
                "gtm_fmu/core/envelope.c",
                "gtm_fmu/core/grid.c",
                "gtm_fmu/core/thrust_map.c",
                "gtm_fmu/core/configuration.c",
                "gtm_fmu/core/full_motion.c",
                "gtm_fmu/core/full_table.c",
                "gtm_fmu/core/simulation.c",
                "gtm_fmu/core/generated/airframe.c",
                "gtm_fmu/core/generated/atmosphere.c",
                "gtm_fmu/core/generated/tables.c",
                "gtm_fmu/core/generated/full_airframe.c",
                "gtm_fmu/core/generated/full_tables.c",
                "gtm_fmu/core/generated/actuators.c",
            ],
            include_dirs=["gtm_fmu/core"],
            libraries=[] if sys.platform == "win32" else ["m"],
            depends=[
                "gtm_fmu/core/gtm_core.h",
                "gtm_fmu/core/gtm_configuration.h",
                "gtm_fmu/core/gtm_simulation.h",
                "gtm_fmu/core/table.h",
                "gtm_fmu/core/full_table.h",
                "gtm_fmu/core/kernel.h",
                "gtm_fmu/core/solver.h",
                "gtm_fmu/core/thrust_map.h",
            ],
            extra_compile_args=[] if sys.platform == "win32" else C_FLAGS,
        )
    ],
    cmdclass={"build_py": BuildPackages, "build_ext": BuildCore, "bdist_wheel": PlatformWheel},
)
