"""Any configuration of the airframe: damage, fuel, fixed and separate surfaces, engines apart, wind (SPEC 4, 5, 10).

Functions as those of `motion` and with the arrays described there, but each engine has a throttle: u (.., 5) in the
order of `names.TWO_THROTTLE_CONTROLS`. Steady manoeuvres y (.., 10) follow `names.TWO_THROTTLE_UNKNOWNS`.
"""

import ctypes
import operator
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.configuration import RANGES
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.names import (
    ACCELERATED,
    COEFFICIENTS,
    OUTPUTS,
    STATES,
    TWO_THROTTLE_CONTROLS,
    TWO_THROTTLE_UNKNOWNS,
)
from gtm_fmu.airframe.surfaces import COMMANDED, FLAPS, SPOILERS
from gtm_fmu.airframe.wind import RUNWAY_ALTITUDE_FT
from gtm_fmu.core.library import address, library, rows
from gtm_fmu.errors import InputError

NX, NU, NY = len(STATES), len(TWO_THROTTLE_CONTROLS), len(OUTPUTS)
NT, NF = len(TWO_THROTTLE_UNKNOWNS), len(ACCELERATED)


class _Struct(ctypes.Structure):
    """The public part of ``gtm_configuration`` in gtm_configuration.h."""

    _fields_ = (
        ("damage_case", ctypes.c_int),
        ("fuel_used_lb", ctypes.c_double),
        ("stabilizer_deg", ctypes.c_double),
        ("gear", ctypes.c_double),
        ("spoiler_deg", ctypes.c_double * len(SPOILERS)),
        ("flap_deg", ctypes.c_double * len(FLAPS)),
        ("surface_gain", ctypes.c_double * len(COMMANDED)),
        ("surface_offset_deg", ctypes.c_double * len(COMMANDED)),
        ("engine_running", ctypes.c_int * 2),
        ("wind_ft_s", ctypes.c_double * 3),
        ("gust_ft_s", ctypes.c_double * 3),
        ("has_shear", ctypes.c_int),
        ("runway_altitude_ft", ctypes.c_double),
        ("has_stall_asymmetry", ctypes.c_int),
        ("mass_factor", ctypes.c_double),
        ("cg_offset_ft", ctypes.c_double * 3),
        ("coefficient_factor", ctypes.c_double * len(COEFFICIENTS)),
        ("mass", ctypes.c_double),
        ("cg", ctypes.c_double * 3),
        ("inertia", ctypes.c_double * 6),
    )


_TYPES: dict[str, Any] = dict(_Struct._fields_)
_CHECKED = ("damage_case", *RANGES)
"""By fault, counted from 1 (``enum gtm_configuration_fault``)."""


class MassProperties(NamedTuple):
    """Mass in slug, centre of gravity (3) in ft in the frame of SPEC 1, Ixx Iyy Izz Ixz Iyz Ixy in slug ft^2."""

    mass: float
    cg: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True)
class Configuration:
    """What is given besides state and controls; by default the study's (SPEC 9).

    Attributes:
        damage_case: 0 none, 1 rudder off, 2 vertical tail off, 3 left outboard flap off, 4 a quarter of the left wing
            off, 5 left elevator off, 6 left stabiliser off (SPEC 10.5).
        fuel_used_lb: fuel burnt.
        stabilizer_deg: its setting.
        gear: 0 up .. 1 down.
        spoiler_deg: (4) left inboard, left outboard, right inboard, right outboard.
        flap_deg: (4) in the same order.
        surface_gain: (8) part of its command that each of `surfaces.COMMANDED` follows; 0 if jammed.
        surface_offset_deg: (8) added to what follows the command.
        engine_running: left, right.
        wind_ft_s: (3) north, east, down: where the air moves (SPEC 10.6).
        gust_ft_s: (3) the same along the body axes.
        has_shear: whether the wind grows with the height above the runway.
        runway_altitude_ft: where that height begins.
        has_stall_asymmetry: whether one wing stalls before the other (SPEC 5.6).
        mass_factor: of mass and inertia.
        cg_offset_ft: (3) by which the centre of gravity lies forward, to the right and down from where it should.
        coefficient_factor: (6) of each of `names.COEFFICIENTS`, all tables summed (SPEC 5).

    Raises:
        InputError: a value of the wrong kind, or outside `airframe.configuration.RANGES`.
    """

    damage_case: int = 0
    fuel_used_lb: float = 0.0
    stabilizer_deg: float = 0.0
    gear: float = 0.0
    spoiler_deg: tuple[float, ...] = (0.0,) * len(SPOILERS)
    flap_deg: tuple[float, ...] = (0.0,) * len(FLAPS)
    surface_gain: tuple[float, ...] = (1.0,) * len(COMMANDED)
    surface_offset_deg: tuple[float, ...] = (0.0,) * len(COMMANDED)
    engine_running: tuple[bool, bool] = (True, True)
    wind_ft_s: tuple[float, ...] = (0.0, 0.0, 0.0)
    gust_ft_s: tuple[float, ...] = (0.0, 0.0, 0.0)
    has_shear: bool = True
    runway_altitude_ft: float = RUNWAY_ALTITUDE_FT
    has_stall_asymmetry: bool = False
    mass_factor: float = 1.0
    cg_offset_ft: tuple[float, ...] = (0.0, 0.0, 0.0)
    coefficient_factor: tuple[float, ...] = (1.0,) * len(COEFFICIENTS)

    def __post_init__(self) -> None:
        """Store every value as plain numbers and check it."""
        for field in fields(self):
            object.__setattr__(self, field.name, _plain(field.name, getattr(self, field.name)))
        _struct(self)

    @property
    def mass_properties(self) -> MassProperties:
        """Of this fuel, gear and damage (SPEC 3)."""
        struct = _struct(self)
        return MassProperties(struct.mass, np.array(struct.cg), np.array(struct.inertia))


def _plain(name: str, value: Any) -> float | bool | tuple[float | bool, ...]:
    """A value as int, float, bool or a tuple of them."""
    kind = _TYPES[name]
    is_vector = hasattr(kind, "_length_")
    is_whole = (kind._type_ if is_vector else kind) is ctypes.c_int
    convert = operator.index if name == "damage_case" else bool if is_whole else float
    try:
        if not is_vector:
            return convert(value)
        if len(value) == kind._length_:
            return tuple(convert(item) for item in value)
    except (TypeError, ValueError):
        pass
    wanted = "a whole number" if name == "damage_case" else "true or false" if is_whole else "a number"
    raise InputError(f"{name} is {value!r}; give {f'{kind._length_} values, each {wanted}' if is_vector else wanted}.")


@lru_cache(maxsize=1024)
def _struct(configuration: Configuration) -> _Struct:
    """The completed struct; it lives in memory of the size the core asks for."""
    size = library().gtm_configuration_size
    size.restype = ctypes.c_long
    struct = _Struct.from_buffer(ctypes.create_string_buffer(size()))
    for field in fields(configuration):
        value = getattr(configuration, field.name)
        setattr(struct, field.name, _TYPES[field.name](*value) if isinstance(value, tuple) else value)
    is_case = struct.damage_case == configuration.damage_case  # it may not fit
    fault = library().gtm_configure(ctypes.byref(struct)) if is_case else _CHECKED.index("damage_case") + 1
    if fault:
        name = _CHECKED[fault - 1]
        lowest, highest = RANGES.get(name, (0, len(DAMAGE_CASES) - 1))
        raise InputError(f"{name} is {getattr(configuration, name)}; allowed are {lowest:g} .. {highest:g}.")
    return struct


def reference(configuration: Configuration) -> "ctypes._CArgObject":
    """What the core's functions take; it keeps the struct alive."""
    return ctypes.byref(_struct(configuration))


def _call(
    name: str, configuration: Configuration, arguments: list[np.ndarray], *widths: tuple[int, ...]
) -> list[np.ndarray]:
    """Results (.., *width) of a batched function; arguments (.., n) are broadcast to one leading shape."""
    leading = np.broadcast_shapes(*(argument.shape[:-1] for argument in arguments))
    arguments = [np.ascontiguousarray(np.broadcast_to(each, (*leading, each.shape[-1]))) for each in arguments]
    results = [np.empty((*leading, *width)) for width in widths]
    count = ctypes.c_long(int(np.prod(leading)))
    arrays = (address(array) for array in (*arguments, *results))
    getattr(library(), name)(reference(configuration), count, *arrays)
    return results


def _state(x: ArrayLike, u: ArrayLike) -> list[np.ndarray]:
    return [rows(x, NX, "x"), rows(u, NU, "u")]


def derivatives(x: ArrayLike, u: ArrayLike, configuration: Configuration) -> np.ndarray:
    """State derivatives (.., 12) per second."""
    return _call("gtm_configured_derivatives_batch", configuration, _state(x, u), (NX,))[0]


def outputs(x: ArrayLike, u: ArrayLike, configuration: Configuration) -> np.ndarray:
    """Outputs (.., 15) in the order and units of `names.OUTPUTS`."""
    return _call("gtm_configured_outputs_batch", configuration, _state(x, u), (NY,))[0]


def jacobian(x: ArrayLike, u: ArrayLike, configuration: Configuration) -> tuple[np.ndarray, np.ndarray]:
    """State derivatives (.., 12) and their derivatives (.., 12, 17) with respect to (x, u)."""
    dx, slopes = _call("gtm_configured_jacobian_batch", configuration, _state(x, u), (NX,), (NX, NX + NU))
    return dx, slopes


def outputs_jacobian(x: ArrayLike, u: ArrayLike, configuration: Configuration) -> tuple[np.ndarray, np.ndarray]:
    """Outputs (.., 15) and their derivatives (.., 15, 17) with respect to (x, u)."""
    y, slopes = _call("gtm_configured_outputs_jacobian_batch", configuration, _state(x, u), (NY,), (NY, NX + NU))
    return y, slopes


def _one_state(x: ArrayLike) -> np.ndarray:
    state = rows(x, NX, "x")
    if state.ndim != 1:
        raise ValueError(f"x has shape {state.shape}; give one state of length {NX}.")
    return state


def wind_body(x: ArrayLike, configuration: Configuration) -> np.ndarray:
    """Velocity (3) of the air in body axes, ft/s, at a state (12) (SPEC 10.6)."""
    state, wind = _one_state(x), np.empty(3)
    library().gtm_configured_wind(reference(configuration), address(state), address(wind))
    return wind


def state_fault(x: ArrayLike, configuration: Configuration) -> int:
    """Why a state (12) has no derivatives, as `motion.state_fault`, with the motion relative to the air."""
    state = _one_state(x)
    return library().gtm_configured_state_fault(reference(configuration), address(state))


def _manoeuvre(y: ArrayLike, altitude: ArrayLike, gamma: ArrayLike) -> list[np.ndarray]:
    scalars = (np.asarray(value, dtype=float)[..., None] for value in (altitude, gamma))
    return [*scalars, rows(y, NT, "y")]


def trim_residual(y: ArrayLike, altitude: ArrayLike, gamma: ArrayLike, configuration: Configuration) -> np.ndarray:
    """Accelerations F (.., 6) relative to the air, ft/s^2 and rad/s^2, of y (.., 10) at ft and rad.

    A steady wind does not enter: speed, flow angles and gamma are those relative to the air.
    """
    return _call("gtm_configured_trim_residual_batch", configuration, _manoeuvre(y, altitude, gamma), (NF,))[0]


def trim_jacobian(
    y: ArrayLike, altitude: ArrayLike, gamma: ArrayLike, configuration: Configuration
) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations F (.., 6) as `trim_residual` and their derivatives (.., 6, 10) with respect to y."""
    F, slopes = _call(
        "gtm_configured_trim_jacobian_batch", configuration, _manoeuvre(y, altitude, gamma), (NF,), (NF, NT)
    )
    return F, slopes


def trim_state(
    altitude: float, gamma: float, y: ArrayLike, configuration: Configuration
) -> tuple[np.ndarray, np.ndarray]:
    """State x (12), moving with the wind, and controls u (5) of the steady manoeuvre y (10) at ft and rad."""
    y = rows(y, NT, "y")
    x, u = np.empty(NX), np.empty(NU)
    at = ctypes.c_double(altitude), ctypes.c_double(gamma)
    library().gtm_configured_trim_state(reference(configuration), *at, address(y), address(x), address(u))
    return x, u
