"""The reference values of the tests are those of the specification, docs/airframe.md."""

import re
from pathlib import Path

import numpy as np

from tests.reference import spec_values

PAGE = (Path(__file__).parents[2] / "docs" / "airframe.md").read_text(encoding="utf-8")
NUMBERS = {float(number) for number in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?", PAGE)}


def printed(value) -> set[float]:
    """All numbers of a reference value: as text, as numbers, or inside of a container."""
    if isinstance(value, str):
        return {float(word) for word in value.split()}
    if isinstance(value, dict):
        return {number for inner in value.values() for number in printed(inner)}
    if isinstance(value, tuple | np.ndarray):
        return {number for inner in value for number in printed(inner)}
    return set() if value is None else {float(value)}


def test_values_are_those_of_the_page():
    names = [name for name in vars(spec_values) if name.isupper() and "HELD" not in name and name != "TRIMS"]
    assert len(names) >= 15
    for name in names:
        assert printed(getattr(spec_values, name)) <= NUMBERS, name


def test_trims_are_those_of_the_page():
    for trim in spec_values.TRIMS:
        assert printed(trim[3 + 1 :]) <= NUMBERS | {0.0}, trim.name


def test_sections():
    """What the code cites as SPEC n is there."""
    sections = set(re.findall(r"^#{2,3} (\d+(?:\.\d+)?) ", PAGE, re.MULTILINE))
    folders = ("gtm_fmu", "fmu_src", "tests", "study", "examples")
    files = [path for folder in folders for path in (Path(__file__).parents[2] / folder).rglob("*.py")]
    cited = {number for path in files for number in re.findall(r"SPEC (\d+(?:\.\d+)?)", path.read_text())}
    assert len(cited) >= 10
    assert cited <= sections
