"""The aerodynamic data: against the database and against what the specification states about its numbers."""

from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import polynomial
from scipy.io import loadmat, savemat

from gtm_fmu.airframe.names import COEFFICIENTS
from gtm_fmu.airframe.refit import least_squares_operator, main, refit
from gtm_fmu.airframe.tables import DATA_FILE, LAYOUTS, load_tables
from gtm_fmu.errors import InputError

database_path = Path(__file__).parents[4] / "shared" / "gtm" / "T2_polynomial_aerodatabase.mat"
needs_database = pytest.mark.skipif(
    not database_path.exists(), reason="the aerodynamic database is not beside this checkout"
)

LATERAL = [1, 3, 5]
MIRROR = np.array([1, -1, 1, -1, 1, -1])


@pytest.fixture(scope="module")
def database_path(shared_folder):
    return shared_folder / "gtm" / "T2_polynomial_aerodatabase.mat"


@pytest.fixture(scope="module")
def database(database_path):
    return loadmat(database_path, simplify_cells=True)


@pytest.fixture(scope="module")
def tables():
    return load_tables()


def database_entry(database, name):
    entry = database
    for part in name.split("."):
        entry = entry[part]
    return entry


# Against the database


def test_every_table_of_the_database_is_there(tables, database):
    names = {key for key, entry in database.items() if isinstance(entry, dict)}
    damage = {f"dC6_damage.{key}" for key, entry in database["dC6_damage"].items() if isinstance(entry, dict)}
    assert names - {"dC6_damage"} | damage == set(tables) | {"dC3_sym"}
    assert not database["dC3_sym"]["data"].any()


@pytest.mark.parametrize("name", LAYOUTS)
def test_values_and_breakpoints_are_the_database(tables, database, name):
    table = tables[name]
    entry = database_entry(database, name)
    if name == "flaps":
        expected = np.array([entry[panel] for panel in ("flaplob", "flaplib", "flaprib", "flaprob")])
    else:
        expected = entry["data"]
    assert table.values.shape == expected.shape
    assert np.abs(table.values - expected).max() <= 1e-12
    for axis in {"alpha", "beta", "rud", "ail", "stab", "elev", "spo", "phat", "qhat", "rhat", "what"} & set(entry):
        np.testing.assert_array_equal(table.axis(axis), entry[axis])


def test_components_and_axis_order_are_those_the_database_states(tables, database):
    for name in ("C6_bas", "dC6_rud", "dC6_ail", "dC3_ele", "dC6_spo", "dC3_lgr", "dC6_w", "dC6_damage.bas"):
        *axes, components = database_entry(database, name)["dim"].split("] x")
        assert tuple(components.strip(" []").split()) == tables[name].components
        for stated, axis in zip(axes, tables[name].axis_names, strict=True):
            assert axis[:3] in stated
    for name in ("dC3_p", "dC3_q", "dC3_r"):
        stated = database_entry(database, name)["doc"].split("outputs are ")[1].split(",")
        assert tuple(component.removeprefix("d") for component in stated) == tables[name].components


def test_refit_reproduces_the_committed_bytes(database_path, tmp_path):
    account = refit(database_path, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == DATA_FILE.read_bytes()
    assert [entry.table for entry in account] == list(LAYOUTS)
    assert max(entry.residual for entry in account) <= 1e-12


def test_refit_refuses_a_table_its_form_cannot_hold(database_path, tmp_path):
    contents = {
        key: entry for key, entry in loadmat(database_path, simplify_cells=True).items() if not key.startswith("__")
    }
    contents["dC6_rud"]["data"][3, 4, 1, 2] += 1e-9
    savemat(tmp_path / "changed.mat", contents)
    output = tmp_path / "aerodynamics.npz"
    output.write_bytes(b"kept")
    with pytest.raises(InputError, match="more than 1e-12 in dC6_rud;"):
        refit(tmp_path / "changed.mat", output)
    assert output.read_bytes() == b"kept"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["aerodynamics.npz", "changed.mat"]


def test_refit_prints_what_the_documentation_shows(database_path, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["refit", str(database_path), "--output", str(tmp_path / "data.npz")])
    main()
    residuals, size, _ = capsys.readouterr().out.rsplit("\n", 2)
    documented = (Path(__file__).parents[3] / "docs" / "aerodynamic-data.md").read_text()
    assert residuals in documented
    assert size == f"{DATA_FILE.stat().st_size} bytes in {tmp_path / 'data.npz'}"


def test_file_is_small():
    assert DATA_FILE.stat().st_size <= 1_000_000


@pytest.mark.parametrize(
    ("database", "output", "message"),
    [
        ("missing.mat", "data.npz", "missing.mat cannot be read: No such file or directory"),
        ("text.mat", "data.npz", "text.mat is not the aerodynamic database"),
        ("other.mat", "data.npz", "other.mat is not the aerodynamic database: KeyError"),
    ],
)
def test_refit_of_another_file_is_refused_in_one_sentence(tmp_path, capsys, monkeypatch, database, output, message):
    (tmp_path / "text.mat").write_text("no database\n" * 100)
    savemat(tmp_path / "other.mat", {"x": 1.0})
    monkeypatch.setattr("sys.argv", ["refit", str(tmp_path / database), "--output", str(tmp_path / output)])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 2
    complaint = capsys.readouterr().err
    assert message in complaint
    assert complaint.count("\n") == 1


@pytest.mark.parametrize("contents", [b"", b"text", DATA_FILE.read_bytes()[:100_000]])
def test_damaged_data_file_is_refused(tmp_path, contents):
    (tmp_path / "data.npz").write_bytes(contents)
    with pytest.raises(InputError, match=r"data\.npz is damaged or no aerodynamic data file"):
        load_tables(tmp_path / "data.npz")


def test_missing_data_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"There is no aerodynamic data file .*data\.npz"):
        load_tables(tmp_path / "data.npz")


def test_operator_is_the_pseudoinverse():
    points = np.array([-1.0, -0.7, -0.2, 0.0, 0.1, 0.4, 0.9, 1.0])
    expected = np.linalg.pinv(np.polynomial.chebyshev.chebvander(points, 5))
    np.testing.assert_allclose(least_squares_operator(points, 5), expected, atol=1e-13)


# SPEC 12 and the other facts that the specification states about the numbers


def degree_misses(points, lines, degree):
    """Largest least-squares residual per component of polynomials along the first axis of `lines`."""
    vandermonde = polynomial.polyvander(points / np.abs(points).max(), degree)
    flat = lines.reshape(len(points), -1)
    residual = vandermonde @ np.linalg.lstsq(vandermonde, flat, rcond=None)[0] - flat
    return np.abs(residual.reshape(-1, lines.shape[-1])).max(axis=0)


def test_basic_table_is_odd_and_nearly_even_in_sideslip(tables):
    values = tables["C6_bas"].values
    np.testing.assert_array_equal(values[:, :, LATERAL], -values[:, ::-1, LATERAL])
    difference = np.abs(values - values[:, ::-1]).max(axis=(0, 1))
    np.testing.assert_array_equal(np.round(difference[[0, 2]], 3), [0.018, 0.057])
    assert round(difference[4], 2) == 0.13


def test_basic_table_has_the_degrees_the_specification_lists(tables):
    table = tables["C6_bas"]
    alpha, beta, lines = table.axis("alpha"), table.axis("beta"), table.values.transpose(1, 0, 2)

    def miss(component, degree, where):
        return degree_misses(beta, lines[:, where], degree)[COEFFICIENTS.index(component)]

    for component, degree, where in [
        ("CX", 5, alpha <= 85),
        ("CY", 1, alpha <= 60),
        ("CZ", 4, alpha <= 10),
        ("CZ", 2, alpha > 10),
        ("Cl", 3, alpha <= 8),
        ("Cl", 5, alpha > 8),
        ("Cl", 1, alpha > 45),
        ("Cm", 5, alpha <= 85),
        ("Cn", 5, alpha <= 85),
    ]:
        assert miss(component, degree, where) < 1e-12, (component, degree)
    assert miss("CY", 1, alpha > 60) > 1e-6
    assert miss("CZ", 3, alpha <= 10) > 1e-6


@pytest.mark.parametrize(
    ("degree", "expected"),
    [
        (3, [0.029, 0.0045, 0.034, 0.0062, 0.046, 0.0055]),
        (5, [0.015, 0.0019, 0.012, 0.0044, 0.027, 0.0030]),
        (8, [0.0091, 0.0006, 0.0083, 0.0013, 0.015, 0.0021]),
    ],
)
def test_bivariate_fits_miss_by_what_the_specification_lists(tables, degree, expected):
    table = tables["C6_bas"]
    alpha, beta = table.axis("alpha"), table.axis("beta")
    inside = np.ix_(alpha <= 20, np.abs(beta) <= 20)
    values = table.values[inside].reshape(-1, 6)
    a, b = np.meshgrid((alpha[alpha <= 20] - 7.5) / 12.5, beta[np.abs(beta) <= 20] / 20, indexing="ij")
    vandermonde = np.polynomial.chebyshev.chebvander2d(a.ravel(), b.ravel(), [degree, degree])
    misses = np.abs(vandermonde @ np.linalg.lstsq(vandermonde, values, rcond=None)[0] - values).max(axis=0)
    np.testing.assert_allclose(misses, expected, rtol=0.06, atol=5e-5)


@pytest.mark.parametrize("name", ["dC6_rud", "dC6_spo", "dC3_ele", "dC6_w"])
def test_increments_are_polynomials_of_degree_five_in_sideslip(tables, name):
    lines = np.moveaxis(tables[name].values, tables[name].axis_names.index("beta"), 0)
    assert degree_misses(tables[name].axis("beta"), lines, 5).max() < 1e-12


def test_aileron_table_is_polynomial_where_the_specification_says(tables):
    table = tables["dC6_ail"]
    alpha, beta, lines = table.axis("alpha"), table.axis("beta"), table.values.swapaxes(0, 1)
    assert degree_misses(beta, lines[:, alpha <= 10], 5).max() < 1e-12
    stall = degree_misses(beta, lines[:, (alpha >= 11) & (alpha <= 18)], 5)
    beyond = degree_misses(beta, lines[:, (alpha >= 24) & (alpha <= 60)], 5)
    np.testing.assert_array_equal(stall > 1e-6, [name in ("CY", "Cn") for name in COEFFICIENTS])
    np.testing.assert_array_equal(beyond > 1e-6, [name in ("Cl", "Cm", "Cn") for name in COEFFICIENTS])


@pytest.mark.parametrize(("name", "rate"), [("dC3_p", "phat"), ("dC3_q", "qhat"), ("dC3_r", "rhat")])
def test_rate_tables_are_polynomials_of_degree_five(tables, name, rate):
    assert degree_misses(tables[name].axis(rate), tables[name].values.swapaxes(0, 1), 5).max() < 1e-12


def test_tables_vanish_at_zero_deflection_and_rate(tables):
    for name, axis in [
        ("dC6_rud", "rud"),
        ("dC6_ail", "ail"),
        ("dC6_spo", "spo"),
        ("dC6_w", "what"),
        ("dC3_lgr", "gear"),
    ]:
        table = tables[name]
        at_zero = table.values.take(int(np.flatnonzero(table.axis(axis) == 0)[0]), table.axis_names.index(axis))
        assert not at_zero.any(), name
        assert table.values.any(), name
    elevator = tables["dC3_ele"]
    assert not elevator.values[:, :, elevator.axis("stab") == 0][:, :, 0, elevator.axis("elev") == 0].any()


def test_pitch_rate_table_keeps_its_offset(tables):
    """SPEC 5.5: up to 0.05 in CZ at zero rate for alpha <= 12."""
    table = tables["dC3_q"]
    offset = table.values[table.axis("alpha") <= 12][:, table.axis("qhat") == 0.0, table.components.index("CZ")]
    assert 0.03 < np.abs(offset).max() <= 0.0505


def test_damage_increments_have_the_symmetry_and_misses_the_specification_lists(tables):
    table = tables["dC6_damage.bas"]
    misses = degree_misses(table.axis("beta"), table.values.swapaxes(0, 1), 5)
    np.testing.assert_array_equal(np.round(misses, 3), [0.038, 0.013, 0.036, 0.003, 0.025, 0.004])
    asymmetry = np.abs(table.values + MIRROR * -table.values[:, ::-1]).max(axis=(0, 1, 3))
    assert not asymmetry[:2].any()
    assert (asymmetry[2:] > 1e-4).all()


def test_damage_factors_are_those_the_specification_lists(tables):
    """SPEC 10.5: the factors used that differ from 1, and the used part of ddinc."""
    scale, increment = tables["dC6_damage.ddscale"], tables["dC6_damage.ddinc"]
    used = {"p": ("CY", "Cl", "Cn"), "q": ("CX", "CZ", "Cm"), "r": ("CY", "Cl", "Cn")}
    smallest = {
        (int(case), str(rate)): scale.values[:, i, j, [COEFFICIENTS.index(name) for name in used[str(rate)]]].min()
        for i, case in enumerate(scale.axis("damage_case"))
        for j, rate in enumerate(scale.axis("rate"))
    }
    listed = {(1, "r"): 0.55, (2, "r"): 0.0, (3, "p"): 0.11, (4, "p"): 0.48, (5, "q"): 0.73, (6, "q"): 0.16}
    assert {key: round(float(value), 2) for key, value in smallest.items() if value != 1.0} == listed
    largest = np.abs(increment.values[..., 1]).max(axis=0)
    np.testing.assert_array_equal(np.round(largest[:2, 2], 2), [0.90, 0.84])
    assert np.count_nonzero(largest) == 2
