"""Networks as files: the same bits back, the same bytes again, and nothing but whole network files."""

import json
import os

import numpy as np
import pytest

from surrogate import Network


@pytest.fixture
def saved(selection, tmp_path):
    path = tmp_path / "network.json"
    selection.network.save(path)
    return path


def test_a_loaded_network_has_the_same_bits(selection, saved):
    network, loaded = selection.network, Network.load(saved)
    for one, other in zip((*loaded.weights, *loaded.biases), (*network.weights, *network.biases), strict=True):
        assert one.tobytes() == other.tobytes()
    for name in ("input_ranges", "target_ranges", "posterior_factor"):
        assert getattr(loaded, name).tobytes() == getattr(network, name).tobytes(), name
    assert (loaded.beta, loaded.inputs, loaded.outputs) == (network.beta, network.inputs, network.outputs)
    assert (loaded.metrics, loaded.provenance) == (network.metrics, network.provenance)
    X = selection.X[:20]
    assert loaded.predict(X).tobytes() == network.predict(X).tobytes()
    assert loaded.predict_std(X).tobytes() == network.predict_std(X).tobytes()


def test_the_same_network_gives_the_same_bytes(saved, tmp_path):
    Network.load(saved).save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == saved.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["again.json", "network.json"]


def test_every_changed_digit_is_noticed(saved, tmp_path):
    text, noticed = saved.read_text(), 0
    digits = [i for i, c in enumerate(text) if c.isdigit()]
    for i in np.random.default_rng(0).choice(digits, 60, replace=False):
        saved.write_text(text[:i] + str((int(text[i]) + 1) % 10) + text[i + 1 :])
        try:
            loaded = Network.load(saved)
        except ValueError as error:
            noticed += "network.json" in str(error)
        else:  # the 17th digit of a number may round to the same bits
            loaded.save(tmp_path / "loaded.json")
            assert (tmp_path / "loaded.json").read_text() == text
    assert noticed > 55


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a model file"),
        (b"\xff\xfe\x00garbage", "not a model file"),
        (b"[1, 2, 3]", "holds no model"),
        (b'{"format": "other", "version": 1}', "holds no model"),
        (b'{"format": ["surrogate.Network"]}', "holds no model"),
        (b"[" * 100_000, "not a model file"),
        (b'{"format": "surrogate.Network", "version": 1}', "format version 1"),
        (b'{"format": "surrogate.Network", "version": 2}', "checksum"),
        (b'{"format": "surrogate.Network", "version": 2, "model": {"beta": NaN}}', "checksum"),
    ],
)
def test_foreign_files_are_refused(tmp_path, content, message):
    path = tmp_path / "foreign.json"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=message) as error:
        Network.load(path)
    assert "foreign.json" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_cut_file_is_refused(saved):
    saved.write_bytes(saved.read_bytes()[:-200])
    with pytest.raises(ValueError, match="is damaged"):
        Network.load(saved)


def test_a_network_that_lacks_a_part_is_refused(saved):
    from surrogate.models.storage import _checksum

    document = json.loads(saved.read_text())
    for change in ({"inputs": None}, {"biases": [[1.0]]}, {"unknown": 1}):
        content = {key: value for key, value in (document["model"] | change).items() if value is not None}
        saved.write_text(json.dumps(document | {"model": content, "checksum": _checksum(content)}))
        with pytest.raises(ValueError, match="does not fit together"):
            Network.load(saved)


def test_a_missing_file_and_a_missing_folder_are_told(selection, tmp_path):
    with pytest.raises(ValueError, match=r"cannot read .*nothing\.json.* \(No such file"):
        Network.load(tmp_path / "nothing.json")
    with pytest.raises(ValueError, match=r"Cannot write .*absent.* \(No such file"):
        selection.network.save(tmp_path / "absent" / "network.json")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(selection, saved, monkeypatch):
    before = saved.read_bytes()

    def full_disk(source, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full_disk)
    with pytest.raises(ValueError, match="No space left"):
        selection.network.save(saved)
    assert saved.read_bytes() == before
    assert [path.name for path in saved.parent.iterdir()] == ["network.json"]
