"""The variables of GtmSurrogate, and the networks that it carries."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from fmu_src.description.model_description import DISPLAY_UNITS, ModelDescription, Variable, output, si, verdict
from gtm_fmu.aircraft.ranges import ALTITUDE_FT, GAMMA_DEG, WIDEST
from gtm_fmu.envelopes.feasibility import FULL_THROTTLE_PCT, has_envelope
from gtm_fmu.errors import InputError
from surrogate import Network

NETWORKS = ("speeds", "throttle")
"""In the order in which `packaging.build` takes their files: of V_min and V_max, and of t_min."""

_EDGE_UNITS = {"ft": "ft", "deg": "deg", "kn": "kt", "%": "%"}  # as in the names of the networks' variables

USAGE = (
    "V_min and V_max are the slowest and fastest true airspeed of a steady turn or straight flight at this altitude "
    "and flight-path angle with the rudder between rudder.lower and rudder.upper; equal limits are a jam. margin.slow "
    "and margin.fast say how far tas is inside.",
    "Outputs follow the inputs at once, also in Initialization Mode. Where feasible is false there is no envelope, and "
    "the speeds mean nothing. Where in_domain is false the case is outside the training data, and the outputs are "
    "guesses. The standard deviations hold the noise of the data about the network and its uncertain weights.",
    "Reversed rudder limits and values that are not finite are logged in one sentence; the step is discarded and all "
    "values stay as before it. No output is ever NaN.",
)

NATIVE_USAGE = (
    "Partial derivatives of all real outputs with respect to the inputs are exact, also those of the standard "
    "deviations.",
)


def _input(name: str, display: str, start: float, least: float, greatest: float | None, description: str) -> Variable:
    unit, scale = DISPLAY_UNITS[display]
    return Variable(
        name=name,
        description=description,
        causality="input",
        unit=unit,
        display_unit=display,
        start=si(start, display),
        minimum=si(least, display),
        maximum=None if greatest is None else si(greatest, display),
        scale=scale,
    )


_RUDDER = WIDEST["rudder_deg"]
CASE = (
    _input("altitude", "ft", 10000.0, *ALTITUDE_FT, "Geometric altitude"),
    _input("gamma", "deg", 0.0, *GAMMA_DEG, "Flight-path angle, positive in a climb"),
    _input("rudder.lower", "deg", _RUDDER[0], *_RUDDER, "Lower limit of the rudder"),
    _input("rudder.upper", "deg", _RUDDER[1], *_RUDDER, "Upper limit of the rudder"),
)
SPEED = _input("tas", "kn", 100.0, 0.0, None, "True airspeed whose margins are asked")
_CASE_NAMES = tuple(variable.name for variable in CASE)


def _speed(name: str, description: str, depends_on: tuple[str, ...] = _CASE_NAMES) -> Variable:
    return output(name, "kn", description, nominal=50.0, depends_on=depends_on)


def _flag(name: str, description: str) -> Variable:
    return verdict(name, description, depends_on=_CASE_NAMES)


ENVELOPE = (
    _speed("v_min", "Slowest true airspeed of the steady envelope"),
    _speed("v_max", "Fastest true airspeed of the steady envelope"),
    _speed("v_min_std", "Standard deviation of v_min"),
    _speed("v_max_std", "Standard deviation of v_max"),
)
DEFERRED_ENVELOPE = (*ENVELOPE[:2], *(replace(variable, deferred=True) for variable in ENVELOPE[2:]))
"""The standard deviations cost thirty times the speeds."""
FLAGS = (
    _flag("feasible", "Whether there is an envelope at all"),
    _flag("in_domain", "Whether the case is inside the ranges of the training data"),
)
MARGINS = (
    _speed("margin.slow", "tas - v_min", (*_CASE_NAMES, SPEED.name)),
    _speed("margin.fast", "v_max - tas", (*_CASE_NAMES, SPEED.name)),
)


def _edge(variable: Variable) -> tuple[str, str]:
    """Name and unit of a variable in a network, as at the public edge of the project."""
    unit = _EDGE_UNITS[variable.display_unit or ""]
    return f"{variable.name.replace('.', '_')}_{unit}", unit


def read_networks(paths: Sequence[Path]) -> list[Network]:
    """The networks of V_min and V_max and of t_min.

    Raises:
        InputError: missing, damaged or of other variables.
    """
    if len(paths) != len(NETWORKS):
        raise InputError(f"{len(paths)} networks were given for the surrogate FMU: give {' and '.join(NETWORKS)}.")
    inputs = tuple(map(_edge, CASE))
    found: list[Network] = []
    for path, outputs in zip(paths, (tuple(map(_edge, ENVELOPE[:2])), (("t_min_pct", "%"),)), strict=True):
        try:
            network = Network.load(path)
        except ValueError as error:
            raise InputError(str(error)) from error
        if (network.inputs, network.outputs) != (inputs, outputs):
            names = ", ".join(name for name, _ in outputs)
            raise InputError(f"'{path}' is not a network of {names} over {', '.join(name for name, _ in inputs)}.")
        if not (found or network.has_std):  # of the speeds
            raise InputError(f"'{path}' tells no standard deviation: train it with Bayesian regularisation.")
        found.append(network)
    return found


def emulated_envelope(speeds: Network, throttle: Network) -> Callable:
    """V_min, V_max in kn and feasibility by altitude in ft, gamma in deg and the limits of the rudder in deg."""

    def find(altitude_ft: float, gamma_deg: float, rudder_deg: tuple[float, float]) -> tuple[float, float, bool]:
        case = [altitude_ft, gamma_deg, *rudder_deg]
        v_min, v_max = speeds.predict(case).tolist()
        return v_min, v_max, bool(has_envelope(throttle.predict(case)[0]) and v_min <= v_max)

    return find


def surrogate_description(speeds: Network, throttle: Network) -> ModelDescription:
    """The description of GtmSurrogate with these networks."""
    ranges = [
        f"{variable.name} {least:.6g} .. {greatest:.6g} {variable.display_unit}"
        for variable, (least, greatest) in zip(CASE, speeds.input_ranges, strict=True)
    ]
    sizes = " and ".join("-".join(map(str, network.sizes)) for network in (speeds, throttle))
    return ModelDescription(
        name="GtmSurrogate",
        title="Steady flight envelope of the GTM-T2 with a failed rudder, by trained networks",
        groups={"case": CASE, "speed": (SPEED,), "envelope": ENVELOPE, "flags": FLAGS, "margins": MARGINS},
        stop_time=1.0,
        step_size=0.1,
        usage=(*USAGE, f"Training data of these networks ({sizes} neurons): {', '.join(ranges)}."),
        constants={"full_throttle_pct": FULL_THROTTLE_PCT},
    )
