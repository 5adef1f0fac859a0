"""The autopilot's slave: it follows a flight plan, and keeps its airspeed inside the envelope if it is told to.

It needs nothing but pythonfmu. All variables are in SI, as those of the aircraft and the envelope that it is wired to.
"""

from math import pi, sin, tan
from xml.etree.ElementTree import SubElement

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

DEG, KT, FT, GRAVITY = pi / 180, 0.3048 / 0.592487, 0.3048, 9.80665
PLAN = (
    # from a time in s on: airspeed in kn, climb and bank in deg
    (0.0, 97.25, 0.0, 0.0),
    (3.0, 90.0, 3.0, 20.0),
    (45.0, 64.0, 3.0, 20.0),
    (90.0, 140.0, 3.0, 20.0),
)
PLANNED = ("tas", "gamma", "phi")
FASTEST_CHANGE = {"tas": 1.5 * KT, "gamma": 1.0 * DEG, "phi": 5.0 * DEG}
"""Of what is followed, per second."""
MARGIN = 8 * KT
"""Kept from V_min and V_max."""
ASKED_EVERY_S = 1.0
ALTITUDES_ASKED = (0.0, 36089 * FT)
MEASURED = ("tas", "gamma", "phi", "p", "q", "r", "altitude", "v_min", "v_max")
REACH = {
    "elevator": (-30 * DEG, 20 * DEG),
    "aileron": (-20 * DEG, 20 * DEG),
    "rudder": (-30 * DEG, 30 * DEG),
    "throttle": (0.0, 1.0),
}


def clamp(value: float, least: float, greatest: float) -> float:
    """A value inside a range."""
    return min(max(value, least), greatest)


def turn_rates(phi: float, tas: float) -> tuple[float, float]:
    """Pitch and yaw rate of a level turn without sideslip."""
    level = GRAVITY / max(tas, 10 * KT) * sin(phi)
    return level * tan(phi), level


class Autopilot(Fmi2Slave):
    """Bank by ailerons, climb by elevator, airspeed by throttle, yaw damping by the rudder."""

    author = "gtm-fmu"
    description = "Follows a flight plan; with is_protected the airspeed stays inside the envelope"

    def __init__(self, **kwargs):
        """Declare the variables."""
        super().__init__(**kwargs)
        self.time, self.next_question = 0.0, 0.0
        self.is_protected = self.feasible = False
        self.sums = dict.fromkeys(("gamma", "elevator", "aileron", "throttle"), 0.0)
        self.commands: dict[str, float] = {}
        self.followed = self.planned()
        self.asked: dict[str, float] = {}
        self.known = {"v_min": 0.0, "v_max": 0.0}
        for name in MEASURED:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Boolean("feasible", causality=Fmi2Causality.input, variability=Fmi2Variability.discrete))
        tunable = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
        self.register_variable(Boolean("is_protected", **tunable))
        for name in REACH:
            setattr(self, f"trim_{name}", 0.0)
            self.register_variable(Real(f"trim_{name}", **tunable))
            self.declare_output(name, lambda name=name: self.commands.get(name, getattr(self, f"trim_{name}")))
        self.declare_output("tas_planned", lambda: self.planned()["tas"])
        self.declare_output("tas_command", lambda: self.followed["tas"])
        self.declare_output("known_v_min", lambda: self.known["v_min"])
        self.declare_output("known_v_max", lambda: self.known["v_max"])
        self.declare_output(
            "altitude_asked", lambda: self.asked.get("altitude", clamp(self.altitude, *ALTITUDES_ASKED))
        )
        self.declare_output("gamma_asked", lambda: self.asked.get("gamma", self.followed["gamma"]))

    def declare_output(self, name: str, getter) -> None:
        """A real output that a function gives."""
        self.register_variable(Real(name, causality=Fmi2Causality.output, getter=getter))

    def to_xml(self, *arguments, **options):
        """The model description of pythonfmu, with what FMI 2.0 asks for besides: what is unknown at the start."""
        root = super().to_xml(*arguments, **options)
        unknowns = SubElement(root.find("ModelStructure"), "InitialUnknowns")
        for output in root.findall("ModelStructure/Outputs/Unknown"):
            SubElement(unknowns, "Unknown", index=output.get("index"))
        return root

    def planned(self) -> dict[str, float]:
        """The leg of the plan at this time."""
        _, tas, gamma, phi = next(leg for leg in reversed(PLAN) if leg[0] <= self.time + 1e-6)
        return {"tas": tas * KT, "gamma": gamma * DEG, "phi": phi * DEG}

    def protected(self, tas: float) -> float:
        """An airspeed inside the envelope, with its margin."""
        if not (self.is_protected and self.feasible):
            return tas
        middle = (self.v_min + self.v_max) / 2
        return clamp(tas, min(self.v_min + MARGIN, middle), max(self.v_max - MARGIN, middle))

    def integrated(self, name: str, rate: float, error: float, gain: float, step: float) -> float:
        """A command from its trim, a rate and an integral that stops where the control ends; it reverses the sign."""
        command = getattr(self, f"trim_{name}") + rate + self.sums[name]
        held = clamp(command, *REACH[name])
        if held == command or (command - held) * gain * error < 0:
            self.sums[name] += gain * error * step
        return held

    def follow(self, step: float) -> None:
        """Move what is followed towards the plan, no faster than allowed."""
        wanted = self.planned()
        wanted["tas"] = self.protected(wanted["tas"])
        for name in PLANNED:
            most = FASTEST_CHANGE[name] * step
            self.followed[name] += clamp(wanted[name] - self.followed[name], -most, most)

    def control(self, step: float) -> None:
        """The four commands."""
        climb_error = self.followed["gamma"] - self.gamma
        self.sums["gamma"] += 0.1 * clamp(climb_error, -3 * DEG, 3 * DEG) * step
        q_turn, r_turn = turn_rates(self.phi, self.tas)
        q_error = clamp(0.8 * climb_error + self.sums["gamma"] + q_turn, -8 * DEG, 8 * DEG) - self.q
        p_error = clamp(self.followed["phi"] - self.phi, -20 * DEG, 20 * DEG) - self.p
        tas_error = self.followed["tas"] - self.tas
        self.commands = {
            "elevator": self.integrated("elevator", -0.3 * q_error, q_error, -0.8, step),
            "aileron": self.integrated("aileron", -0.12 * p_error, p_error, -0.3, step),
            "rudder": clamp(self.trim_rudder + 0.5 * (self.r - r_turn), *REACH["rudder"]),
            "throttle": self.integrated("throttle", 0.04 / KT * tas_error, tas_error, 0.003 / KT, step),
        }

    def do_step(self, current_time, step_size):
        """One step: the commands are those at its end."""
        self.known = {"v_min": self.v_min, "v_max": self.v_max}
        self.follow(step_size)
        self.control(step_size)
        self.time = current_time + step_size
        if self.time >= self.next_question - 1e-6:
            self.next_question += ASKED_EVERY_S
            self.asked = {"altitude": clamp(self.altitude, *ALTITUDES_ASKED), "gamma": self.followed["gamma"]}
        return True
