"""`fsel view`: what it takes for what, and the page it writes."""

import json
import re

import numpy as np
import pytest
from browsing import decoded, pictures
from small_captures import write_ring

from fsel.captures.images import previews
from fsel.cli import main
from fsel.reconstruct import ply


@pytest.fixture
def made(tmp_path):
    """A capture, a selection of it and a model."""
    write_ring(tmp_path / "ring")
    arguments = ["-k", "5", "--targets", "every:8", "--patience", "0", "--quiet"]
    assert main(["select", str(tmp_path / "ring"), *arguments, "-o", str(tmp_path / "picked")]) == 0
    one = np.ones((1, 3))
    ply.write_round(tmp_path / "model.ply", one, one * 0.5, one[:, 0] * 0.5, one[:, 0] * 0.1)
    return tmp_path


def data_of(page):
    (found,) = re.findall(r'<script type="application/json" id="view-data">(.*?)</script>', page)
    return json.loads(found)


def test_a_selection_colours_the_cameras_of_its_capture(made, capsys):
    (made / "picked" / "model.ply").write_bytes((made / "model.ply").read_bytes())
    out = made / "page.html"
    assert main(["view", str(made / "picked"), "-o", str(out)]) == 0
    said = capsys.readouterr().out
    assert "24 cameras, colmap: 5 picked, 3 held out, 16 left out" in said
    content = data_of(out.read_text())
    assert 'id="keep"' in out.read_text()  # of the report, which holds the scene
    picks = [entry for entry in content["cameras"] if entry["state"] == "pick"]
    record = json.loads((made / "picked" / "selection.json").read_text())
    orders = {entry["name"]: entry["order"] for entry in record["frames"]}
    assert {entry["name"]: entry["order"] for entry in picks} == orders
    assert content["model"]
    assert all(entry["picture"].startswith("data:image/jpeg") for entry in content["cameras"])
    assert main(["view", str(made / "picked"), "-o", str(out)]) == 1
    assert main(["view", str(made / "picked"), "-o", str(out), "--force"]) == 0


def test_a_capture_alone_shows_its_points_and_many_photos_smaller(made, monkeypatch):
    monkeypatch.setattr(previews, "LARGE", 6)  # of 24, so that each has half the side
    arguments = ["view", str(made / "ring"), "--long-side", "60"]
    assert main([*arguments, "-o", str(made / "page.html")]) == 0
    page = (made / "page.html").read_text()
    assert [decoded(picture).shape[1] for picture in pictures(page)] == [30] * 24
    content = data_of(page)
    assert (content["model"], len(content["points"]["xyz"])) == (None, 80)
    assert {entry["state"] for entry in content["cameras"]} == {"frame"}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["gone"], "gone: does not exist"),
        (["ring", "ring"], "a second capture"),
        (["model.ply", "-o", "page.txt"], "page.txt: a page must be an .html file"),
        (["broken"], "selection.json: is not a record of fsel select"),
        (["empty.ply"], "empty.ply: contains no Gaussians"),
    ],
)
def test_what_cannot_be_shown_is_refused(given, said, made, monkeypatch, capsys):
    monkeypatch.chdir(made)
    (made / "broken").mkdir()
    (made / "broken" / "selection.json").write_text("{}")
    nothing = np.zeros((0, 3))
    ply.write_round("empty.ply", nothing, nothing, nothing[:, 0], nothing[:, 0])
    out = [] if "-o" in given else ["-o", "page.html"]
    assert main(["view", *given, *out]) == 1
    assert said in capsys.readouterr().err
    assert not (made / "page.html").exists()
