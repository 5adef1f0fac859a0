"""A data set as one flat table: every digit, every ending, and what cannot be written."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gtm_fmu.datasets import export, results
from gtm_fmu.errors import InputError
from tests.gtm_fmu.datasets.rudder_store import TABLE, fill


@pytest.fixture(scope="module")
def found() -> dict[str, np.ndarray]:
    return results.evaluate(TABLE.rows(0, 6))


@pytest.fixture
def path(tmp_path, found) -> Path:
    return fill(tmp_path / "jams.zarr", found)


class TestExport:
    def test_csv_holds_every_digit(self, path, tmp_path, found):
        table = pd.read_csv(export.export(path, tmp_path / "new" / "a.csv"), dtype=str, keep_default_na=False)
        assert len(table) == 6
        assert list(table)[:2] == ["altitude_ft", "gamma_deg"]
        for name, label in (("v_min", "v_min_kt"), ("t_min", "t_min_pct"), ("phi_at_v_max", "phi_at_v_max_deg")):
            assert [float(text or "nan") for text in table[label]] == pytest.approx(
                found[name], rel=0, abs=0, nan_ok=True
            )
        assert table.rudder_upper_deg.tolist() == ["0.0", "3.0", "10.0", "14.5", "22.0", "30.0"]
        assert table.feasible.tolist() == ["True"] * 5 + ["False"]
        spelled = [" ".join(results.limit_names(int(bits))) for bits in found["limits_at_v_max"]]
        assert table.limits_at_v_max.tolist() == spelled
        assert "throttle.upper" in spelled[0]

    def test_parquet_holds_every_digit(self, path, tmp_path, found):
        pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra `parquet`)")
        table = pd.read_parquet(export.export(path, tmp_path / "a.parquet"))
        np.testing.assert_array_equal(table.v_max_kt, found["v_max"])
        assert table.limits_at_v_min[5] == ""

    def test_only_finished_cases(self, tmp_path, found):
        path = fill(tmp_path / "half.zarr", found, range(4, 6))
        table = pd.read_csv(export.export(path, tmp_path / "half.csv"))
        assert table.rudder_lower_deg.tolist() == [22.0, 30.0]

    def test_parquet_without_pyarrow(self, path, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "pyarrow", None)
        with pytest.raises(InputError, match=r"Parquet needs pyarrow: `pip install 'gtm-fmu\[parquet\]'`"):
            export.export(path, tmp_path / "a.parquet")

    @pytest.mark.parametrize(
        ("target", "sentence"), [("a.xls", "is neither .csv nor .parquet"), ("file/a.csv", "Cannot write")]
    )
    def test_bad_target(self, path, tmp_path, target, sentence):
        (tmp_path / "file").touch()
        with pytest.raises(InputError, match=sentence):
            export.export(path, tmp_path / target)

    def test_scratched_store_leaves_the_earlier_table(self, path, tmp_path):
        target = export.export(path, tmp_path / "a.csv")
        kept = target.read_bytes()
        (path / "v_max" / "c" / "1").write_bytes(b"")
        with pytest.raises(InputError, match="is damaged at cases 4 to 5"):
            export.export(path, target)
        assert target.read_bytes() == kept
        assert sorted(file.name for file in tmp_path.iterdir()) == ["a.csv", "jams.zarr"]
