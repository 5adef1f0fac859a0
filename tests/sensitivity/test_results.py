"""Results as tables and figures; samples that grow; what an import brings."""

import json
import subprocess
import sys

import numpy as np
import pytest

from sensitivity import (
    convergence,
    effects_design,
    full_independent_indices,
    given_data_indices,
    interaction_design,
    interactions,
    pawn_indices,
    shapley_design,
    variance_design,
    variance_indices,
    variance_indices_until,
)
from sensitivity import test_functions as functions

F = functions.ISHIGAMI


def both(x):
    return np.column_stack([F(x), x[:, 1]])


def results():
    distribution = F.distribution
    table = distribution.sample(np.random.default_rng(0).random((400, 3)))
    return {
        "variance": variance_indices(variance_design(distribution, 256).evaluate(both, ["f", "x2"])),
        "interactions": interactions(interaction_design(distribution, 256).evaluate(both, ["f", "x2"])),
        "shapley": shapley_design(distribution, 256).evaluate(both, ["f", "x2"]),
        "full": full_independent_indices(distribution, both, 256, output_names=["f", "x2"]),
        "effects": effects_design(distribution, 20).evaluate(both, ["f", "x2"]),
        "given": given_data_indices(table, both(table), output_names=["f", "x2"]),
        "pawn": pawn_indices(table, both(table), output_names=["f", "x2"]),
    }


RESULTS = results()


@pytest.mark.parametrize("name", RESULTS)
class TestResults:
    def test_data_frame(self, name):
        result = RESULTS[name]
        frame = result.to_df().set_index(["output", "input", "kind"])
        assert len(frame) == 2 * len(result.row_names) * len(result.kinds)
        kind, row = result.kinds[-1], result.row_names[1]
        assert frame.loc[("x2", row, kind), "value"] == result.estimates[kind].value[1, 1]
        assert frame.loc[("x2", row, kind), "upper"] == result.estimates[kind].upper[1, 1]

    def test_xarray(self, name):
        result = RESULTS[name]
        data = result.to_xarray()
        kind, row = result.kinds[0], result.row_names[-1]
        found = data[kind].sel(input=row, output="f", number="lower").item()
        assert found == result.estimates[kind].lower[-1, 0]

    def test_json(self, name):
        document = json.loads(RESULTS[name].to_json())
        assert set(document["outputs"]) == {"f", "x2"}
        assert document["confidence"] == 0.95

    def test_figure(self, name, tmp_path):
        RESULTS[name].plot(labels={"x1": "first"}).savefig(tmp_path / "figure.png")
        assert (tmp_path / "figure.png").stat().st_size > 5000


def test_pairs_and_convergence_figures(tmp_path):
    from sensitivity import plot_pairs

    plot_pairs(RESULTS["interactions"]).savefig(tmp_path / "pairs.png")
    steps = convergence(variance_design(F.distribution, 2048).evaluate(F))
    steps.plot().savefig(tmp_path / "convergence.png")
    assert steps.n_base == (256, 512, 1024, 2048)
    errors = [np.abs(step.first.value[:, 0] - F.first).max() for step in steps.steps]
    assert errors[-1] < 0.01 < errors[0]
    with pytest.raises(ValueError, match="do not grow"):
        convergence(variance_design(F.distribution, 256).evaluate(F))


@pytest.mark.parametrize("sampling", ["sobol", "random"])
def test_head_is_the_smaller_design(sampling):
    large, small = (
        variance_indices(variance_design(F.distribution, n, sampling=sampling, seed=4).evaluate(F)) for n in (2048, 512)
    )
    part = variance_indices(variance_design(F.distribution, 2048, sampling=sampling, seed=4).evaluate(F).head(512))
    np.testing.assert_allclose(part.first.value, small.first.value, rtol=1e-12)
    assert not np.allclose(part.first.value, large.first.value, rtol=1e-6)


class TestUntil:
    @pytest.mark.parametrize(("sampling", "width"), [("sobol", 0.02), ("random", 0.05)])
    def test_as_narrow_as_asked(self, sampling, width):
        seen, rows = [], []

        def counting(x):
            rows.append(len(x))
            return F(x)

        found = variance_indices_until(
            counting, F.distribution, width, least=64, sampling=sampling, progress=lambda n, w: seen.append((n, w))
        )
        assert found.half_width <= width < seen[-2][1]
        np.testing.assert_allclose(found.first.value[:, 0], F.first, atol=2 * width)
        assert sum(rows) == found.design.n_evaluations  # nothing twice
        again = variance_indices(variance_design(F.distribution, seen[-1][0], sampling=sampling).evaluate(F))
        np.testing.assert_allclose(found.total.value, again.total.value, rtol=1e-12)

    def test_too_few_rows_allowed(self):
        found = variance_indices_until(F, F.distribution, 1e-6, least=64, most=128)
        assert found.design.n_base == 128
        assert found.half_width > 1e-6

    def test_refused(self):
        with pytest.raises(ValueError, match="above 0"):
            variance_indices_until(F, F.distribution, 0.0)
        with pytest.raises(ValueError, match="cannot grow"):
            variance_indices_until(F, F.distribution, 0.1, sampling="latin")


def test_numpy_and_scipy_alone():
    """The package imports and works with everything else hidden."""
    script = """
import sys
class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in "matplotlib pandas xarray casadi fmpy torch sklearn gtm_fmu surrogate".split():
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Hidden())
import sensitivity as s
f = s.test_functions.ISHIGAMI
print(s.variance_indices(s.variance_design(f.distribution, 64).evaluate(f)).to_json()[:1])
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.stdout == "{\n", done.stderr


@pytest.mark.parametrize("options", [{"confidence": 1.0}, {"confidence": float("nan")}, {"n_bootstrap": 1}])
def test_what_makes_no_interval_is_refused(options):
    x = F.distribution.sample(np.random.default_rng(0).random((400, 3)))
    for measure in (
        lambda: given_data_indices(x, F(x), **options),
        lambda: pawn_indices(x, F(x), **options),
        lambda: effects_design(F.distribution, 20).evaluate(F, **options),
        lambda: variance_indices(variance_design(F.distribution, 256).evaluate(F), **options),
    ):
        with pytest.raises(ValueError, match=r"give (a number between 0 and 1|at least 2)"):
            measure()


def test_samples_grow_until_intervals_of_the_given_confidence_are_narrow():
    """Student's t over 8 replicates: 3.4995 / 2.3646 as wide at 99 % as at 95 %."""
    wide, usual = (
        variance_indices_until(F, F.distribution, 0.5, least=256, confidence=confidence) for confidence in (0.99, 0.95)
    )
    assert wide.half_width / usual.half_width == pytest.approx(3.4995 / 2.3646, rel=1e-4)
