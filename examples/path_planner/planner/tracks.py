"""Tracks of steady manoeuvres over ground: straight lines, circles and helices, carried along by the wind."""

from typing import NamedTuple

import numpy as np

from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG

FT_PER_M = 1.0 / M_PER_FT


class Wind(NamedTuple):
    """Where the air moves, in m/s."""

    north_m_s: float = 0.0
    east_m_s: float = 0.0


CALM = Wind()


def displacement(
    tas_kt: np.ndarray, gamma_deg: np.ndarray, turn_rate_deg_s: np.ndarray, time_s: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """How far ahead and to the right in m, up in ft and turned in deg, through the air, after times.

    With psi = psi_dot t and U = V cos(gamma):  ahead = U sin(psi) / psi_dot,  right = U (1 - cos(psi)) / psi_dot.
    Arguments broadcast against each other.
    """
    speed = tas_kt * M_S_PER_KT
    along, climb = speed * np.cos(gamma_deg * RAD_PER_DEG), speed * np.sin(gamma_deg * RAD_PER_DEG)
    turned = turn_rate_deg_s * RAD_PER_DEG * time_s
    half = 0.5 * turned
    chord = along * time_s * np.sinc(half / np.pi)  # 2 R sin(psi / 2), and V t where nothing turns
    return chord * np.cos(half), chord * np.sin(half), climb * time_s * FT_PER_M, turned / RAD_PER_DEG


def over_ground(
    ahead_m: np.ndarray, right_m: np.ndarray, heading_deg: float, time_s: np.ndarray, wind: Wind
) -> tuple[np.ndarray, np.ndarray]:
    """North and east in m of a displacement through the air from this heading, with the wind's drift."""
    cosine, sine = np.cos(heading_deg * RAD_PER_DEG), np.sin(heading_deg * RAD_PER_DEG)
    north = ahead_m * cosine - right_m * sine + wind.north_m_s * time_s
    east = ahead_m * sine + right_m * cosine + wind.east_m_s * time_s
    return north, east


def heading_for_track(track_deg: float, airspeed_m_s: float, wind: Wind) -> tuple[float, float] | None:
    """Heading in deg and ground speed in m/s that hold a track against the wind; None where that is too strong.

    The wind triangle: V sin(heading - track) = -(wind across), ground speed = V cos(heading - track) + wind along.
    """
    cosine, sine = np.cos(track_deg * RAD_PER_DEG), np.sin(track_deg * RAD_PER_DEG)
    along = wind.north_m_s * cosine + wind.east_m_s * sine
    across = -wind.north_m_s * sine + wind.east_m_s * cosine
    if abs(across) >= airspeed_m_s:
        return None
    offset = -np.arcsin(across / airspeed_m_s)
    ground = airspeed_m_s * np.cos(offset) + along
    return (float(track_deg + offset / RAD_PER_DEG), float(ground)) if ground > 0 else None
