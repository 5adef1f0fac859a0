"""The FMUs under test, built once."""

import ctypes
import fcntl
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import fmpy
import numpy as np
import pytest

from fmu_src import build
from gtm_fmu.aircraft.client import FmuClient
from surrogate import Network, Variable
from tests.fmu_src.native_session import SESSIONS, Session


@pytest.fixture(scope="session")
def built(tmp_path_factory) -> Callable[..., Path]:
    """A function that builds an FMU, once for all processes that run tests."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "fmus"

    def once(name: str, networks=()) -> Path:
        place = folder / name
        place.mkdir(parents=True, exist_ok=True)
        with open(place / "lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            return next(place.glob("*.fmu"), None) or build(name, place, networks)

    return once


@pytest.fixture(scope="session")
def dynamics_fmu(built) -> Path:
    return built("dynamics")


@pytest.fixture(scope="session")
def native_fmus(built) -> dict[int, Path]:
    """The native dynamics FMUs by their FMI version."""
    return {2: built("dynamics-native"), 3: built("dynamics-native3")}


AIRCRAFT = ("aircraft", "aircraft-native", "aircraft-native3")


@pytest.fixture(scope="session")
def aircraft_fmus(built) -> dict[str, Path]:
    """GtmAircraft and the native ones by their short names."""
    return {name: built(name) for name in AIRCRAFT}


@pytest.fixture(scope="session")
def native_folders(native_fmus, tmp_path_factory) -> dict[int, Path]:
    """The same, unpacked."""
    return {fmi: Path(fmpy.extract(path, tmp_path_factory.mktemp(f"fmi{fmi}"))) for fmi, path in native_fmus.items()}


@pytest.fixture(scope="session")
def envelope_fmus(built) -> dict[int | str, Path]:
    """The envelope FMU in Python, and the native ones by their FMI version."""
    return {"python": built("envelope"), 2: built("envelope-native"), 3: built("envelope-native3")}


@pytest.fixture(scope="session")
def envelope_folders(envelope_fmus, tmp_path_factory) -> dict[int, Path]:
    """The native ones, unpacked."""
    folder = tmp_path_factory.mktemp("unpacked")
    return {fmi: Path(fmpy.extract(envelope_fmus[fmi], folder / str(fmi))) for fmi in (2, 3)}


@pytest.fixture(scope="session")
def manoeuvre_fmus(built) -> dict[int | str, Path]:
    """The manoeuvre FMU in Python, and the native ones by their FMI version."""
    return {"python": built("manoeuvre"), 2: built("manoeuvre-native"), 3: built("manoeuvre-native3")}


@pytest.fixture(scope="session")
def thrust_map_fmus(built) -> dict[int, Path]:
    """The thrust map FMUs by their FMI version."""
    return {2: built("thrust-map-native"), 3: built("thrust-map-native3")}


def read(fmu: FmuClient, references) -> tuple[int, list[float]]:
    """Status and values of real variables by FMI, whatever the status."""
    references = list(references)
    asked, values = (ctypes.c_uint * len(references))(*references), (ctypes.c_double * len(references))()
    component = ctypes.c_void_p(fmu.instance.component)
    status = fmu.instance.dll.fmi2GetReal(component, asked, len(references), values)
    return status, list(values)


CASE = (("altitude_ft", "ft"), ("gamma_deg", "deg"), ("rudder_lower_deg", "deg"), ("rudder_upper_deg", "deg"))
CASE_RANGES = ((0.0, 30000.0), (-5.0, 5.0), (-30.0, 30.0), (-30.0, 30.0))


def random_network(seed: int, hidden: int, outputs: tuple, target_range: tuple[float, float]) -> Network:
    """A network with random weights: its evaluation is under test, not what it has learnt."""
    rng = np.random.default_rng(seed)
    count = len(outputs)
    parameters = hidden * (len(CASE) + 1) + count * (hidden + 1)
    return Network(
        weights=(rng.normal(size=(hidden, len(CASE))), 0.4 * rng.normal(size=(count, hidden))),
        biases=(rng.normal(size=hidden), 0.2 * rng.normal(size=count)),
        input_ranges=np.array(CASE_RANGES),
        target_ranges=np.array([target_range] * count),
        inputs=tuple(Variable(*pair) for pair in CASE),
        outputs=tuple(Variable(*pair) for pair in outputs),
        beta=200.0,
        posterior_factor=0.01 * np.triu(rng.normal(size=(parameters, parameters))),
    )


def random_networks(seed: int, folder: Path) -> tuple[Network, Network, list[Path]]:
    """A network of V_min and V_max, one of t_min, and their files."""
    speeds = random_network(seed, 10, (("v_min_kt", "kt"), ("v_max_kt", "kt")), (60.0, 160.0))
    throttle = random_network(seed + 1, 7, (("t_min_pct", "%"),), (30.0, 170.0))
    paths = [folder / "speeds.json", folder / "throttle.json"]
    speeds.save(paths[0])
    throttle.save(paths[1])
    return speeds, throttle, paths


@pytest.fixture(scope="session")
def networks(tmp_path_factory) -> tuple[Network, Network, list[Path]]:
    return random_networks(1, tmp_path_factory.mktemp("networks"))


@pytest.fixture(scope="session")
def surrogate_fmu(networks, built) -> Path:
    return built("surrogate", networks[2])


@pytest.fixture(scope="session")
def native_surrogates(networks, built) -> dict[int, Path]:
    """The native surrogate FMUs by their FMI version."""
    return {2: built("surrogate-native", networks[2]), 3: built("surrogate-native3", networks[2])}


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def fmi(request) -> int:
    """The FMI version of a native FMU."""
    return request.param


def sessions(folder: Path, fmi: int) -> Iterator[Callable[..., Session]]:
    """A function that instantiates a native FMU and initializes it; what it made is freed."""
    opened: list[Session] = []

    def instantiate(kind="cs", *, is_initialized=True, is_exited=True, **arguments) -> Session:
        opened.append(SESSIONS[fmi](folder, kind, **arguments))
        if is_initialized:
            opened[-1].initialize(is_exited=is_exited)
        return opened[-1]

    yield instantiate
    for session in opened:
        session.free()


@pytest.fixture
def start(fmi, native_folders):
    yield from sessions(native_folders[fmi], fmi)


@pytest.fixture
def envelope_session(fmi, envelope_folders):
    yield from sessions(envelope_folders[fmi], fmi)
