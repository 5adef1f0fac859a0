"""Directional and adjoint derivatives against the core's Jacobians and differences of the FMU itself."""

import math

import numpy as np
import pytest

from gtm_fmu import core
from tests.fmu_src.native_flight import DX, NX, U0, U_SI, X0, X_SI, Y_SI, U, X, Y, put, random_points, read
from tests.fmu_src.native_session import ERROR, OK, SESSIONS

pytestmark = pytest.mark.slow


def exact_slopes(x, u):
    """Slopes of derivatives and outputs (27, 16) in SI by the core."""
    known = np.append(X_SI, U_SI)
    rates, outputs = core.jacobian(x, u)[1], core.outputs_jacobian(x, u)[1]
    return np.vstack([rates * X_SI[:, None], outputs * Y_SI[:, None]]) / known


class TestPartialDerivatives:
    UNKNOWNS, KNOWNS = [int(v) for v in (*DX, *Y)], [int(v) for v in (*X, *U)]

    @pytest.mark.parametrize("kind", ["cs", "me"])
    def test_against_the_core(self, start, kind):
        session = start(kind, is_exited=False)
        for x, u in zip(*random_points(20), strict=True):
            put(session, x, u)
            expected = exact_slopes(x, u)
            for column, known in enumerate(self.KNOWNS):
                status, slopes = session.directional(self.UNKNOWNS, [known], [1.0])
                assert status == OK
                np.testing.assert_allclose(slopes, expected[:, column], rtol=1e-12, atol=1e-14)

    def test_against_differences_of_the_fmu(self, start):
        """Central ones; points nearer to a breakpoint of the tables than the step have another slope and are few."""
        session = start("me", is_exited=False)
        errors = []
        for x, u in zip(*random_points(20), strict=True):
            put(session, x, u)
            for known in self.KNOWNS:
                slopes = np.array(session.directional(self.UNKNOWNS, [known], [1.0])[1])
                (value,) = read(session, [known])
                step = 1e-6 * max(1.0, abs(value))
                ends = []
                for end in (value + step, value - step):
                    session.set([known], [end])
                    ends.append(read(session, self.UNKNOWNS))
                session.set([known], [value])
                difference = (ends[0] - ends[1]) / (2 * step)
                errors.append(np.abs(difference - slopes) / np.maximum(np.abs(slopes), 1))
        assert np.quantile(np.max(errors, axis=1), 0.98) < 1e-5

    def test_directions_add_up(self, start):
        session = start("me", is_exited=False)
        x, u = (points[0] for points in random_points(1))
        put(session, x, u)
        seed = np.random.default_rng(2).normal(size=len(self.KNOWNS))
        status, result = session.directional(self.UNKNOWNS, self.KNOWNS, seed)
        assert status == OK
        np.testing.assert_allclose(result, exact_slopes(x, u) @ seed, rtol=1e-12, atol=1e-12)

    def test_adjoint(self, native_folders):
        with SESSIONS[3](native_folders[3], "me") as session:
            session.initialize()
            x, u = (points[0] for points in random_points(1))
            put(session, x, u)
            seed = np.random.default_rng(2).normal(size=len(self.UNKNOWNS))
            status, result = session.adjoint(self.UNKNOWNS, self.KNOWNS, seed)
            assert status == OK
            np.testing.assert_allclose(result, exact_slopes(x, u).T @ seed, rtol=1e-12, atol=1e-12)

    def test_states_as_outputs_and_parameters(self, start):
        session = start("me", is_exited=False)
        names = session.names
        assert session.directional([int(X[2])], [int(X[2]), int(X[3])], [2.0, 5.0]) == (OK, [2.0])
        assert session.directional([int(DX[0])], [names["solver.substep"], names["time"]], [1.0, 1.0]) == (OK, [0.0])
        assert session.directional([int(DX[0])], [int(Y[0])], [1.0])[0] == ERROR
        assert session.directional([names["limits.rudder.lower"]], [int(X[0])], [1.0])[0] == ERROR

    def test_held_controls(self, start):
        """A held control passes its slope to the limit that holds it; a jam has none."""
        session = start("me", is_exited=False)
        names = session.names
        q = names["der(state.q)"]
        knowns = [names[name] for name in ("control.elevator", "limits.elevator.lower", "limits.elevator.upper")]
        slope = exact_slopes(X0 / X_SI, U0 / U_SI)[4, NX]

        def slopes():
            return [session.directional([q], [known], [1.0])[1][0] for known in knowns]

        assert slopes() == [pytest.approx(slope), 0, 0]
        session.set_named(limits__elevator__upper=0.0)
        at_zero = exact_slopes(X0 / X_SI, np.array([0, *(U0 / U_SI)[1:]]))[4, NX]
        assert slopes() == [0, 0, pytest.approx(at_zero)]
        session.set_named(limits__elevator__upper=0.5, limits__elevator__lower=0.1)
        assert slopes()[::2] == [0, 0]
        assert slopes()[1] != 0
        session.set_named(limits__elevator__upper=0.1, control__elevator=0.1)
        assert slopes() == [0, 0, 0]

    def test_seed_that_is_not_finite(self, start):
        session = start("me", is_exited=False)
        for seed in (math.nan, math.inf, 1e308):
            status, result = session.directional([int(DX[0])], [int(X[0]), int(X[1])], [seed, seed])
            assert status == ERROR or np.isfinite(result).all()
