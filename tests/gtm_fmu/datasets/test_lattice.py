"""The lattice data set: its cases and units, and the view of its store."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.datasets import paper
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.errors import InputError

ALTITUDES_FT = (0.0, 30000.0)
GAMMAS_DEG = (-5.0, 0.0, 5.0)
FAILURES = [(-30.0, 30.0), (8.0, 8.0), (-25.0, -18.0), (30.0, 30.0)]


@pytest.fixture(scope="module")
def store(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("lattice") / "lattice.zarr"


@pytest.fixture(scope="module")
def lattice(store) -> xr.Dataset:
    return dataset.solved(store, dataset.lattice(ALTITUDES_FT, GAMMAS_DEG, FAILURES), workers=1)


def test_the_lattice_of_the_paper():
    """4 altitudes, 11 flight-path angles (paper Table 7), 7 jams and 21 restrictions: 1232 cases."""
    failures = dataset.rudder_failures(paper.RUDDERS_DEG)
    assert len(failures) == len(set(failures)) == 28
    assert sum(lower == upper for lower, upper in failures) == 7
    assert all(-30 <= lower <= upper <= 30 for lower, upper in failures)
    assert paper.ALTITUDES_FT == (0, 10000, 20000, 30000)
    assert list(paper.GAMMAS_DEG) == list(range(-5, 6))
    assert len(paper.ALTITUDES_FT) * len(paper.GAMMAS_DEG) * len(failures) == 1232


def test_every_case_is_the_envelope_of_its_coordinates(lattice):
    assert dict(lattice.sizes) == {"altitude": 2, "gamma": 3, "failure": 4}
    feasible = 0
    for i, j, k in np.ndindex(2, 3, 4):
        case = lattice.isel(altitude=i, gamma=j, failure=k)
        assert (float(case.altitude), float(case.gamma)) == (ALTITUDES_FT[i], GAMMAS_DEG[j])
        assert (float(case.rudder_lower), float(case.rudder_upper)) == FAILURES[k]
        found = envelope(ALTITUDES_FT[i], GAMMAS_DEG[j], ControlLimits(rudder_deg=FAILURES[k]))
        assert bool(case.feasible) == found.feasible
        least = np.nan if found.t_min_pct is None else found.t_min_pct
        np.testing.assert_equal(float(case.t_min), least)
        for end in ("v_min", "v_max"):
            trim = getattr(found, f"at_{end}")
            names = {"alpha": "deg", "turn_rate": "deg_s", "elevator": "deg", "throttle": "pct", "rudder": "deg"}
            expected = {f"{name}_at_{end}": getattr(trim, f"{name}_{unit}", None) for name, unit in names.items()}
            for name, value in ({end: getattr(found, f"{end}_kt")} | expected).items():
                np.testing.assert_equal(float(case[name]), value if found.feasible else np.nan)
        feasible += found.feasible
    assert 8 < feasible < 24


def test_units_are_attributes(lattice):
    units = {"altitude": "ft", "gamma": "deg", "rudder_lower": "deg", "rudder_upper": "deg"}
    units |= {"v_min": "kt", "v_max": "kt", "t_min": "%"}
    units |= {"phi_at_v_min": "deg", "turn_rate_at_v_max": "deg/s", "throttle_at_v_min": "%"}
    for name, unit in units.items():
        assert lattice[name].attrs["units"] == unit
    assert len(lattice.attrs["aerodynamic_data_sha256"]) == 64
    assert lattice.attrs["gtm_fmu_version"]


def test_progress_and_workers(lattice, tmp_path):
    reports = []
    table = dataset.lattice(ALTITUDES_FT, GAMMAS_DEG, FAILURES)
    again = dataset.solved(tmp_path / "a.zarr", table, lambda done, all_: reports.append((done, all_)), 2)
    xr.testing.assert_identical(again, lattice)
    assert reports[-1] == (24, 24)


def test_samples_follow_their_inputs(lattice):
    inputs, speeds, least = dataset.samples(lattice)
    assert inputs.shape == (24, 4)
    assert speeds.shape == (24, 2)
    assert least.shape == (24,)
    for row, (v_min, v_max), t_min in zip(inputs, speeds, least, strict=True):
        altitude_ft, gamma_deg, lower, upper = row
        k = FAILURES.index((lower, upper))
        case = lattice.sel(altitude=altitude_ft, gamma=gamma_deg).isel(failure=k)
        np.testing.assert_equal([v_min, v_max, t_min], [float(case[name]) for name in ("v_min", "v_max", "t_min")])
    assert len(np.unique(inputs, axis=0)) == 24


@pytest.mark.parametrize(
    ("altitudes", "gammas", "failures"),
    [
        ([], GAMMAS_DEG, FAILURES),
        (ALTITUDES_FT, [], FAILURES),
        (ALTITUDES_FT, GAMMAS_DEG, []),
        ([40000.0], GAMMAS_DEG, FAILURES),
        ([np.nan], GAMMAS_DEG, FAILURES),
        (ALTITUDES_FT, [60.0], FAILURES),
        (ALTITUDES_FT, GAMMAS_DEG, [(5.0, -5.0)]),
        (ALTITUDES_FT, GAMMAS_DEG, [(-40.0, 0.0)]),
        (ALTITUDES_FT, GAMMAS_DEG, [(0.0, np.nan)]),
    ],
)
def test_wrong_axes(altitudes, gammas, failures):
    with pytest.raises(InputError) as told:
        dataset.lattice(altitudes, gammas, failures)
    assert str(told.value).endswith(".")
    assert "\n" not in str(told.value)


def test_a_store_of_another_lattice_is_replaced(lattice, store, tmp_path):
    """And one of this lattice is only read."""
    path = tmp_path / "lattice.zarr"
    shutil.copytree(store, path)
    xr.testing.assert_identical(dataset.solved(path, dataset.lattice(ALTITUDES_FT, GAMMAS_DEG, FAILURES)), lattice)
    assert (path / "v_min" / "c" / "0").stat().st_mtime_ns == (store / "v_min" / "c" / "0").stat().st_mtime_ns
    smaller = dataset.solved(path, dataset.lattice(ALTITUDES_FT[:1], GAMMAS_DEG, FAILURES), workers=1)
    np.testing.assert_array_equal(smaller.v_min, lattice.v_min.isel(altitude=[0]))


@pytest.mark.parametrize("foreign", ["letters.zarr", "other.zarr", "file.zarr"])
def test_nothing_but_a_store_is_replaced(lattice, tmp_path, foreign):
    path = tmp_path / foreign
    if foreign == "file.zarr":
        path.write_text("Dear")
    if foreign == "other.zarr":
        lattice[["v_min"]].drop_attrs().to_zarr(path, consolidated=False)
    if foreign == "letters.zarr":
        path.mkdir()
        (path / "letter.txt").write_text("Dear")
    kept = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    with pytest.raises(InputError, match=r"is no readable data set .*; make a new one elsewhere\."):
        dataset.solved(path, dataset.lattice(ALTITUDES_FT, GAMMAS_DEG, FAILURES))
    assert {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()} == kept


def test_levels_in_any_order(tmp_path):
    """The view follows the levels as they were given."""
    data = dataset.solved(tmp_path / "a.zarr", dataset.lattice((20000.0, 0.0), (3.0, -3.0), [(0.0, 0.0)]), workers=1)
    assert (data.altitude.values.tolist(), data.gamma.values.tolist()) == ([20000.0, 0.0], [3.0, -3.0])
    exact = envelope(0.0, 3.0, ControlLimits(rudder_deg=(0.0, 0.0)))
    assert float(data.v_max.sel(altitude=0.0, gamma=3.0).item()) == exact.v_max_kt
