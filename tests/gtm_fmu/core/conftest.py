"""The solver with an aircraft in closed form, compiled once."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import pytest

from gtm_fmu.core.library import library_path
from gtm_fmu.core.sources import WHOLE


@pytest.fixture(scope="session")
def toy(tmp_path_factory) -> ctypes.CDLL:
    """The functions of toy_aircraft.c, and all of the solver's."""
    compiler, core = shutil.which("cc"), library_path().parent
    if compiler is None:
        pytest.skip("no C compiler `cc` on this machine")
    path = tmp_path_factory.mktemp("toy") / "toy.so"
    sources = [core / name for name in WHOLE if name.startswith("solver/")]
    sources.append(Path(__file__).with_name("toy_aircraft.c"))
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", f"-I{core}"]
    subprocess.run([compiler, *flags, *sources, "-o", path, "-lm"], check=True)
    return ctypes.CDLL(str(path))


@pytest.fixture
def draggy(toy):
    """Lets sideslip make drag until the test ends: throttle per square degree of rudder, and the rudder without any."""

    def set_drag(per_square_deg: float, rudder_without: float) -> None:
        toy.toy_set_drag(ctypes.c_double(per_square_deg), ctypes.c_double(rudder_without))

    yield set_drag
    set_drag(0.0, 0.0)
