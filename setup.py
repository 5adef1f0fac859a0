"""Build steps of the compiled parts: the core, whose C is generated from the airframe, and networks."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from runpy import run_path

from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
CORE = ROOT / "gtm_fmu" / "core"
SOURCES = run_path(str(CORE / "sources.py"))["WHOLE"]
C_FLAGS = ["-std=c99", "-O3", "-fno-math-errno", "-g0", "-fvisibility=hidden"]
# Loops over the samples of a network become vector instructions.
VECTOR_FLAGS = ["-ffp-contract=fast", "-fno-trapping-math"]
# Another platform than this one, as Zig calls it, and the tag of its wheel: `build_wheels.py` sets both.
TARGET, WHEEL_PLATFORM = (os.environ.get(f"GTM_FMU_{name}", "") for name in ("ZIG_TARGET", "WHEEL_PLATFORM"))
SYSTEM = next((each for each in ("windows", "macos", "linux") if each in TARGET), sys.platform)
LIBRARY_SUFFIX = {"windows": ".dll", "win32": ".dll", "macos": ".dylib", "darwin": ".dylib"}.get(SYSTEM, ".so")


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
    """Shared libraries that no Python is linked into: ctypes loads them, and FMUs load the core from any host."""

    def run(self):
        generate_sources()
        super().run()

    def build_extensions(self):
        if TARGET:
            zig = [sys.executable, "-m", "ziglang", "cc", "-target", TARGET, "-s"]
            pic = [] if SYSTEM == "windows" else ["-fPIC"]
            self.compiler.set_executables(compiler_so=[*zig, *pic], linker_so=[*zig, "-shared"])
        # Python's own link flags may carry a library path of this machine; the library travels in FMUs.
        linker = getattr(self.compiler, "linker_so", None)
        if linker:
            self.compiler.linker_so = [flag for flag in linker if not flag.startswith(("-L", "-Wl,-rpath"))]
        one_by_one = self.compiler.compile

        def compile_side_by_side(sources, **options):
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                objects = pool.map(lambda path: one_by_one([path], **options), sources)
                return [name for names in objects for name in names]

        self.compiler.compile = compile_side_by_side
        super().build_extensions()

    def get_ext_filename(self, fullname):
        return str(Path(*fullname.split("."))) + LIBRARY_SUFFIX

    def get_export_symbols(self, ext):
        return []


class PlatformWheel(bdist_wheel):
    """The library depends on the platform but not on the Python version."""

    def get_tag(self):
        return "py3", "none", WHEEL_PLATFORM or super().get_tag()[2]


setup(
    ext_modules=[
        Extension(
            "gtm_fmu.core.gtm_core",
            sources=[f"gtm_fmu/core/{name}" for name in SOURCES],
            include_dirs=["gtm_fmu/core"],
            libraries=[] if sys.platform == "win32" else ["m"],
            depends=[path.relative_to(ROOT).as_posix() for path in sorted(CORE.rglob("*.h"))],
            extra_compile_args=[] if sys.platform == "win32" else C_FLAGS,
        ),
        Extension(
            "surrogate.core.network",
            sources=["surrogate/core/network.c"],
            extra_compile_args=[] if sys.platform == "win32" else [*C_FLAGS, *VECTOR_FLAGS],
        ),
    ],
    cmdclass={"build_py": BuildPackages, "build_ext": BuildCore, "bdist_wheel": PlatformWheel},
)
