"""The tables as the core evaluates them when it is loaded, against the data file's, looked up as SPEC 5 says."""

import ctypes
import os
import re
import shutil
import subprocess
from math import prod

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from gtm_fmu.airframe.lookup_axes import lookup_axes
from gtm_fmu.airframe.names import COEFFICIENTS
from gtm_fmu.airframe.tables import load_tables
from gtm_fmu.core import stored_tables
from gtm_fmu.core.library import library_path
from gtm_fmu.core.sources import WHOLE

SOURCES = (
    *(f"gtm/{name}.c" for name in ("unfold", "table", "configured_table")),
    *(f"generated/{name}.c" for name in ("tables", "configured_tables")),
)
MIRROR = np.array([1, -1, 1, -1, 1, -1])
"""Of CX CY CZ Cl Cm Cn in a mirrored aircraft."""


@pytest.fixture(scope="module")
def tables():
    return load_tables()


@pytest.fixture(scope="module")
def axes():
    """By the names of the axes in the database."""
    axes = lookup_axes()
    common = {"alpha": axes.alpha, "beta": axes.beta, "stab": axes.stabilizer_deg, "case": np.arange(6)}
    surfaces = {"elev": axes.elevator_deg, "ail": axes.aileron_deg, "rud": axes.rudder_deg, "spo": axes.spoiler_deg}
    rates = {"phat": axes.p_hat, "qhat": axes.q_hat, "rhat": axes.r_hat, "what": axes.omega_hat}
    return common | surfaces | rates


@pytest.fixture(scope="module")
def unfolded(tmp_path_factory, axes):
    """Reads a table of the core by its name in C and its axes; the number of components is padded there to 4 or 8."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler `cc` on this machine")
    core, path = library_path().parent, tmp_path_factory.mktemp("tables") / "tables.so"
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", f"-I{core}"]
    subprocess.run(["cc", *flags, *(core / name for name in SOURCES), "-o", path, "-lm"], check=True)
    library = ctypes.CDLL(str(path))

    def read(name: str, *axis_names: str, components: int = 6) -> np.ndarray:
        shape = (*(len(axes[axis]) for axis in axis_names), 8 if components > 4 else 4)
        values = np.array((ctypes.c_double * prod(shape)).in_dll(library, f"gtm_{name}_table")).reshape(shape)
        assert not values[..., components:].any()
        return values[..., :components]

    return read


@pytest.fixture(scope="module")
def core_lookup(unfolded, axes):
    """The multilinear look-up of a table of the core, in the order of its axes in C."""

    def lookup(name, *axis_names, components=6):
        return interpolated([axes[axis] for axis in axis_names], unfolded(name, *axis_names, components=components))

    return lookup


def interpolated(axes, values):
    """Multilinear, extrapolated with the slope of the end interval (SPEC 1), by SciPy."""
    lookup = RegularGridInterpolator(axes, values, bounds_error=False, fill_value=None)
    return lambda *arguments: lookup(np.stack(np.broadcast_arrays(*arguments), axis=-1))


def data_lookup(table):
    return interpolated(table.axes, table.values)


@pytest.fixture(scope="module")
def points():
    """Random lookup arguments inside and outside every axis."""
    random = np.random.default_rng(5)
    spans = {"alpha": (-45, 100), "beta": (-60, 60), "surface": (-60, 60)}
    return {name: random.uniform(*span, 4000) for name, span in spans.items()} | {"rate": random.uniform(-2, 2, 4000)}


def assert_equal_lookups(actual, expected):
    assert np.abs(expected).max() > 0.1
    assert (np.abs(actual - expected) <= 1e-12 * np.maximum(1.0, np.abs(expected))).all()


def test_basic_lookup(tables, core_lookup, points):
    arguments = points["alpha"], points["beta"]
    assert_equal_lookups(core_lookup("basic", "alpha", "beta")(*arguments), data_lookup(tables["C6_bas"])(*arguments))


def test_rudder_lookup_is_both_halves(tables, core_lookup, points):
    """SPEC 5.2 as it stands: two halves, each by the mirror rule and with its own weights."""
    lookup = data_lookup(tables["dC6_rud"])
    alpha, beta, d = points["alpha"], points["beta"], points["surface"]
    s = np.where(d >= 0, -1.0, 1.0)
    c = lookup(alpha, s * beta, -np.abs(d)) * np.where(MIRROR == -1, s[:, None], 1.0)
    upper, lower = np.array([0.5, 0.5, 0.5, 0.67, 0.67, 0.5]), np.array([0.5, 0.5, 0.5, 0.33, 0.33, 0.5])
    assert_equal_lookups(core_lookup("rudder", "alpha", "beta", "rud")(alpha, beta, d), upper * c + lower * c)


def test_aileron_lookup_is_right_and_left(tables, core_lookup, points):
    """SPEC 5.3 with AILL = -a, AILR = +a (SPEC 4)."""
    lookup = data_lookup(tables["dC6_ail"])
    alpha, beta, a = points["alpha"], points["beta"], points["surface"]
    expected = lookup(alpha, beta, a) + MIRROR * lookup(alpha, -beta, -a)
    assert_equal_lookups(core_lookup("aileron", "alpha", "beta", "ail")(alpha, beta, a), expected)


def test_elevator_lookup_is_four_segments_at_zero_stabiliser(tables, core_lookup, points):
    """SPEC 5.4: the stabiliser contribution and the four segments."""
    lookup = data_lookup(tables["dC3_ele"])
    alpha, beta, e = points["alpha"], points["beta"], points["surface"]
    stabiliser = lookup(alpha, beta, 0.0, 0.0)
    expected = stabiliser + sum(0.25 * (lookup(alpha, beta, 0.0, e) - stabiliser) for _ in range(4))
    assert_equal_lookups(core_lookup("elevator", "alpha", "beta", "elev", components=3)(alpha, beta, e), expected)


@pytest.mark.parametrize("rate", ["p", "q", "r"])
def test_rate_lookup(tables, core_lookup, points, rate):
    table = tables[f"dC3_{rate}"]
    alpha, hat = points["alpha"], points["rate"] * table.axis(f"{rate}hat").max()
    actual = core_lookup(rate, "alpha", f"{rate}hat", components=3)(alpha, hat)
    assert_equal_lookups(actual, data_lookup(table)(alpha, hat))


def test_rotary_lookup(tables, core_lookup, points):
    alpha, hat, beta = points["alpha"], points["rate"] * 0.5, points["beta"]
    expected = data_lookup(tables["dC6_w"])(alpha, hat, beta)
    assert_equal_lookups(core_lookup("omega", "alpha", "beta", "what")(alpha, beta, hat), expected)


@pytest.mark.parametrize(("name", "table", "axis"), [("aileron", "dC6_ail", "ail"), ("spoiler", "dC6_spo", "spo")])
def test_lookup_of_a_right_panel(tables, core_lookup, points, name, table, axis):
    arguments = points["alpha"], points["beta"], points["surface"]
    actual = core_lookup(f"right_{name}", "alpha", "beta", axis)(*arguments)
    assert_equal_lookups(actual, data_lookup(tables[table])(*arguments))


def test_tail_lookup(tables, core_lookup, points):
    alpha, beta, stabiliser, e = points["alpha"], points["beta"], 10 * points["rate"], points["surface"]
    actual = core_lookup("tail", "stab", "alpha", "beta", "elev", components=3)(stabiliser, alpha, beta, e)
    assert_equal_lookups(actual, data_lookup(tables["dC3_ele"])(alpha, beta, stabiliser, e))


def test_gear_lookup(tables, core_lookup, points):
    expected = interpolated(tables["dC3_lgr"].axes[:1], tables["dC3_lgr"].values[:, 1])(points["alpha"])
    assert_equal_lookups(core_lookup("gear", "alpha", components=3)(points["alpha"]), expected)


def test_lookup_of_the_damage_increments(tables, unfolded, axes, points):
    """SPEC 10.5 takes CY alone, one number a rate."""
    table, cy = tables["dC6_damage.ddinc"], COEFFICIENTS.index("CY")
    actual = unfolded("damage_increment", "case", "alpha", components=3)
    for case, values in enumerate(actual):
        expected = interpolated(table.axes[:1], table.values[:, case, :, cy])(points["alpha"])
        assert np.abs(interpolated([axes["alpha"]], values)(points["alpha"]) - expected).max() <= 1e-12
    assert actual.any()


@pytest.mark.parametrize(
    ("name", "table", "axis"),
    [("basic", "C6_bas", None), ("right_aileron", "dC6_ail", "ail"), ("right_spoiler", "dC6_spo", "spo")],
)
def test_breakpoints_of_the_data_have_its_values_to_the_last_bit(tables, unfolded, axes, name, table, axis):
    """NumPy evaluates the polynomials in the data file; the aileron's has lines that are none."""
    at = np.searchsorted(axes["alpha"], tables[table].axis("alpha"))
    values = unfolded(name, *filter(None, ("alpha", "beta", axis)))
    np.testing.assert_array_equal(values[at], tables[table].values)


def test_tables_are_written_at_load_alone(tmp_path):
    """Were they constant, a compiler would find fault with the calls that fill them in and with nothing else."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler `cc` on this machine")
    core = library_path().parent
    for header in core.rglob("*.h"):
        text = re.sub(r"^extern double (?=gtm_\w+_table\[\])", "extern const double ", header.read_text(), flags=re.M)
        copy = tmp_path / header.relative_to(core)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(text)
    users = [name for name in WHOLE if not name.startswith("generated/")]
    for name in users:
        (tmp_path / name).write_bytes((core / name).read_bytes())
    command = ["cc", "-std=c99", "-fsyntax-only", "-fdiagnostics-color=never", "-I.", *users]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})
    found = re.findall(r"^(\S+?):(\d+):\d+: (?:warning|error)", run.stderr, re.MULTILINE)
    complaints = [(tmp_path / name).read_text().splitlines()[int(line) - 1] for name, line in found]
    filled = [re.fullmatch(r" +gtm_unfold\(.*, (gtm_\w+_table)\);", line) for line in complaints]
    assert all(filled), run.stderr
    stored = {*stored_tables.folded(load_tables()), *stored_tables.configured(load_tables()), "right_aileron"}
    assert sorted(match[1] for match in filled if match) == sorted(f"gtm_{name}_table" for name in stored)


def test_folded_surfaces_mirror(unfolded):
    """A mirrored aircraft with mirrored commands has mirrored coefficients: both folded tables are their own image."""
    for name, axis in (("rudder", "rud"), ("aileron", "ail")):
        values = unfolded(name, "alpha", "beta", axis)
        np.testing.assert_array_equal(values[:, ::-1, ::-1], MIRROR * values)
