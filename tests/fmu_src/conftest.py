"""The FMUs under test, built once."""

from pathlib import Path

import pytest

from fmu_src import build


@pytest.fixture(scope="session")
def dynamics_fmu(tmp_path_factory) -> Path:
    return build("dynamics", tmp_path_factory.mktemp("fmu"))
