"""Directional derivatives of the envelope and manoeuvre FMUs against differences of what they find."""

from collections.abc import Callable, Iterator
from pathlib import Path

import fmpy
import numpy as np
import pytest

from tests.fmu_src.conftest import sessions
from tests.fmu_src.native_session import DISCARD, OK, Session
from tests.fmu_src.test_failure_envelopes import DEG, Given, pair

pytestmark = pytest.mark.slow

STEPS = {"m": 2.0, "rad": 2e-6, "m/s": 1e-3, "rad/s": 1e-5, "1": 1e-5, "kg": 1e-4}
TYPICAL = {"m": 1000.0, "rad": 0.1, "m/s": 10.0, "rad/s": 0.1, "1": 0.3, "kg": 3.0}
"""Of the inputs, by unit."""
LIMITED = pair("aileron", -4, 4) | pair("rudder", -2, 6)
FAILED: dict[str, Given] = {
    "jam": pair("rudder", 7, 7) | {"fuel.used": 1.0},
    "range": {**LIMITED, "control.flaps": 0.1},
    "left elevator lost": pair("rudder", -3, 2) | {"damage.case": 5.0},
    "little thrust": pair("rudder", 4, 4) | pair("throttle", 0, 60, 0.01),
}
JUMPING = ("damage.case", "control.gear")
CONDITION = {"altitude": 2000.0, "gamma": -2.5 * DEG}


@pytest.fixture(scope="module")
def folders(envelope_fmus, manoeuvre_fmus, tmp_path_factory) -> dict[tuple[str, int], Path]:
    folder = tmp_path_factory.mktemp("slopes")
    fmus = {"envelope": envelope_fmus, "manoeuvre": manoeuvre_fmus}
    return {(n, k): Path(fmpy.extract(fmus[n][k], folder / f"{n}{k}")) for n in fmus for k in (2, 3)}


@pytest.fixture(params=["envelope", "manoeuvre"])
def start(request, fmi, folders) -> Iterator[Callable[..., Session]]:
    yield from sessions(folders[request.param, fmi], fmi)


def set_all(session: Session, values: Given) -> None:
    assert session.set([session.names[name] for name in values], list(values.values())) == OK


def slopes(session: Session, outputs: list[int], names: list[str]) -> np.ndarray:
    """Along the sum of some inputs."""
    status, found = session.directional(outputs, [session.names[name] for name in names], [1.0] * len(names))
    assert status == OK, session.texts()
    return np.array(found)


@pytest.mark.parametrize("failure", FAILED)
def test_slopes_are_those_of_differences(start, failure):
    """With respect to each input, to one side at least; both limits of a jam are moved together."""
    session = start()
    given = {**CONDITION, **FAILED[failure]}
    is_manoeuvre = "trim.alpha" in session.names
    set_all(session, given | ({"tas": 46.0, "turn_rate": 2 * DEG} if is_manoeuvre else {}))
    variables = {v.name: v for v in session.description.modelVariables}
    told = [n for n, v in variables.items() if n.startswith(("trim.", "margin.")) and v.causality == "output"]
    outputs = [session.names[name] for name in (told if is_manoeuvre else ("v_min", "v_max"))]
    before = np.array(session.get(outputs)[1])
    assert session.get_flags("feasible") == [True]
    is_jam = given["limits.rudder.lower"] == given["limits.rudder.upper"]
    jam = ["limits.rudder.lower", "limits.rudder.upper"] if is_jam else []
    moved = [n for n, v in variables.items() if v.causality == "input" and v.type in ("Real", "Float64")]
    compared = 0
    for names in [*([name] for name in moved if name not in (*JUMPING, "tas", *jam)), *([jam] if jam else [])]:
        variable = variables[names[0]]
        here, sides = session.get([session.names[name] for name in names])[1], []
        for step in (STEPS[variable.unit], -STEPS[variable.unit]):
            if not float(variable.min) <= here[0] + step <= float(variable.max):
                continue
            assert session.set([session.names[name] for name in names], [value + step for value in here]) == OK
            status, after = session.get(outputs)
            assert session.set([session.names[name] for name in names], here) == OK
            if status == OK:
                sides.append((np.array(after) - before) / step)
        found = slopes(session, outputs, names)
        size = np.abs(found) + 1e-2 / TYPICAL[variable.unit]
        is_loose = failure == "little thrust" and names[0] == "limits.throttle.upper"
        is_tied = names[0].startswith("limits.throttle") and not is_loose  # of equal limits one counts
        if sides and not is_tied:
            errors = [np.abs(side - found) / size for side in (*sides, np.mean(sides, axis=0))]
            assert (np.min(errors, axis=0) < 5e-3).all(), (names, found, sides)
            compared += 1
    assert compared > 15


def test_turns_at_their_ends(fmi, folders):
    """The greatest turn rate over the bound of bank; tan(bank) = V rate / g without sideslip, so about g / V."""
    generator = sessions(folders["manoeuvre", fmi], fmi)
    session = next(generator)()
    set_all(session, {**CONDITION, "tas": 46.0, **pair("rudder", 2, 2), **pair("bank", -20, 20)})
    outputs = [session.names["turn_rate.greatest"]]
    bank = [session.names["limits.bank.upper"]]
    found = session.directional(outputs, bank, [1.0])[1][0]
    ends = []
    for angle in (20 * DEG + 1e-3, 20 * DEG - 1e-3):
        assert session.set(bank, [angle]) == OK
        ends.append(session.get(outputs)[1][0])
    assert found == pytest.approx((ends[0] - ends[1]) / 2e-3, rel=5e-3)
    assert 0.1 < found < 0.5
    next(generator, None)


def test_no_slopes(start):
    """Reversed limits: one sentence, and no numbers."""
    session = start("me")
    assert session.set_named(limits__bank__lower=0.2, limits__bank__upper=0.1) == OK
    output = "trim.alpha" if "trim.alpha" in session.names else "v_min"
    assert session.directional([session.names[output]], [session.names["gamma"]], [1.0])[0] == DISCARD
    assert "limits.bank.lower is above limits.bank.upper" in session.texts()[0]
