"""docs/fmus.md: its table of importers is the tested one."""

from pathlib import Path

from tests.fmu_src.importer_matrix import CASES, COLUMNS
from tests.fmu_src.test_importers import OTHERWISE

PAGE = (Path(__file__).parents[2] / "docs" / "fmus.md").read_text(encoding="utf-8")


def test_table_of_importers():
    for model in CASES:
        row = (model, *(OTHERWISE.get((column, model), "yes") for column in COLUMNS))
        assert f"| {' | '.join(row)} |" in PAGE
    assert f"| FMU | {' | '.join(COLUMNS)} |" in PAGE
