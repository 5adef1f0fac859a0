"""What the tests of the native dynamics FMUs share: places, units, random points, a flight."""

import math

import numpy as np

from fmu_src.description.dynamics_variables import dynamics_description
from fmu_src.description.reference_results import DOUBLETS, commands
from gtm_fmu.airframe.names import CONTROLS, OUTPUTS, STATES
from tests.fmu_src.native_session import OK

NX, NU, NY = len(STATES), len(CONTROLS), len(OUTPUTS)
X, DX, U, Y = np.split(np.arange(2 * NX + NU + NY), [NX, 2 * NX, 2 * NX + NU])
GROUPS = dynamics_description().groups
X_SI, U_SI, Y_SI = (np.array([variable.scale for variable in GROUPS[g]]) for g in ("states", "controls", "outputs"))
X0 = np.array([variable.start for variable in GROUPS["states"]])
U0 = np.array([variable.start for variable in GROUPS["controls"]])
DEG = math.pi / 180


def random_points(count, seed=7):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, (count, NX)) * (40, 40, 40, 1, 1, 1, 1, 3, 15000, 1, 1, 3)
    x[:, [0, 8]] += 150, 15000
    return x, rng.uniform(-1, 1, (count, NU)) * (29, 19, 29, 49) + (0, 0, 0, 50)


def read(session, places):
    status, values = session.get([int(place) for place in places])
    assert status == OK, session.messages
    return np.array(values)


def put(session, x, u):
    assert session.set([int(place) for place in (*X, *U)], [*(x * X_SI), *(u * U_SI)]) == OK


def fly(session, steps, step_s=0.02, first=0):
    for i in range(first, first + steps):
        values = commands(i * step_s, dict.fromkeys(DOUBLETS, 0.0))
        session.set(
            [session.names[name] for name in values], [U0[0] + values["control.elevator"], values["control.aileron"]]
        )
        assert session.step(i * step_s, step_s) == OK
    return read(session, X)
