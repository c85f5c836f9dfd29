"""`fsel view`: what it takes for what, the page it writes, and what it serves."""

import json
import re
import socket
import subprocess
import sys
import urllib.request

import numpy as np
import pytest
from browsing import decoded, pictures
from small_captures import write_ring

from fsel.cli import main, view
from fsel.pages import shown
from fsel.pages.viewer import bundle
from fsel.reconstruct import ply


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A capture, a selection of it and a model; the script of the page is a stand-in."""
    write_ring(tmp_path / "ring")
    arguments = ["-k", "5", "--targets", "every:8", "--patience", "0", "--quiet"]
    assert main(["select", str(tmp_path / "ring"), *arguments, "-o", str(tmp_path / "picked")]) == 0
    one = np.ones((1, 3))
    ply.write_round(tmp_path / "model.ply", one, one * 0.5, one[:, 0] * 0.5, one[:, 0] * 0.1)
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(bundle, "SHIPPED", tmp_path / "bundle.js")
    (tmp_path / "bundle.js").write_text(f"/* {bundle._mark()}\n*/")
    return tmp_path


def fetched(place):
    with urllib.request.urlopen(place) as answer:
        return answer.read()


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
    assert 'id="keep-file"' in out.read_text()  # of the report, which holds the scene
    picks = [entry for entry in content["cameras"] if entry["state"] == "pick"]
    record = json.loads((made / "picked" / "selection.json").read_text())
    orders = {entry["name"]: entry["order"] for entry in record["frames"]}
    assert {entry["name"]: entry["order"] for entry in picks} == orders
    assert content["model"]["packed"]
    assert all(entry["picture"].startswith("data:image/jpeg") for entry in content["cameras"])
    assert main(["view", str(made / "picked"), "-o", str(out)]) == 1
    assert main(["view", str(made / "picked"), "-o", str(out), "--force"]) == 0


def test_a_capture_alone_shows_its_points(made):
    assert main(["view", str(made / "ring"), "-o", str(made / "page.html")]) == 0
    content = data_of((made / "page.html").read_text())
    assert content["model"] is None
    assert len(content["points"]["xyz"]) == 80
    assert {entry["state"] for entry in content["cameras"]} == {"frame"}


def test_what_is_left_out_as_bad_is_told_from_duplicates_that_may_be_picked():
    bad = [{"name": "a", "left_out": True}, {"name": "b", "left_out": False}]
    record = {"bad": bad, "left": [{"name": "a", "reason": "bad: blur"}]}
    cameras = view._cameras(["a", "b"], [b"", b""], record)
    assert [camera.state for camera in cameras] == ["bad", "left"]


def test_many_photos_are_smaller(made, monkeypatch):
    monkeypatch.setattr(shown, "LARGE", 6)  # of 24, so that each has half the side
    arguments = ["view", str(made / "ring"), "--long-side", "60"]
    assert main([*arguments, "-o", str(made / "page.html")]) == 0
    found = pictures((made / "page.html").read_text())
    assert [decoded(picture).shape[1] for picture in found] == [30] * 24


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["gone"], "gone: is not there"),
        (["ring", "ring"], "a second capture"),
        (["model.ply", "-o", "page.txt"], "page.txt: a page is written as .html"),
        (["broken"], "selection.json: is no record of fsel select"),
    ],
)
def test_what_cannot_be_shown_is_refused(given, said, made, monkeypatch, capsys):
    monkeypatch.chdir(made)
    (made / "broken").mkdir()
    (made / "broken" / "selection.json").write_text("{}")
    out = [] if "-o" in given else ["-o", "page.html"]
    assert main(["view", *given, *out]) == 1
    assert said in capsys.readouterr().err
    assert not (made / "page.html").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="there, two may listen at one port")
def test_a_model_without_gaussians_is_refused(tmp_path, capsys):
    nothing = np.zeros((0, 3))
    path = tmp_path / "empty.ply"
    ply.write_round(path, nothing, nothing, np.zeros(0), np.zeros(0))
    assert main(["view", str(path), "-o", str(tmp_path / "page.html")]) != 0
    assert "empty.ply: holds no Gaussians" in capsys.readouterr().err
    assert not (tmp_path / "page.html").exists()


def test_a_port_that_another_program_has_is_refused(made, capsys):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        assert main(["view", str(made / "ring"), "--serve", port]) == 1
    assert f"--serve {port}: Address already in use. Hint: another" in capsys.readouterr().err


def test_a_server_gives_the_page_and_the_model(made):
    program = "import sys; from fsel.cli import main; from fsel.pages.viewer import bundle; "
    program += "from pathlib import Path; bundle.SHIPPED = Path(sys.argv.pop(1)); sys.exit(main())"
    command = [sys.executable, "-c", program, made / "bundle.js", "view", made / "model.ply"]
    server = subprocess.Popen([*command, "--serve", "0"], stdout=subprocess.PIPE, text=True)
    try:
        place = next(filter(None, (re.search(r"http://\S+/", line) for line in server.stdout)))[0]
        content = data_of(fetched(place).decode())
        assert content["model"] == {"url": view.MODEL}
        served = made / "served.ply"
        served.write_bytes(fetched(place + view.MODEL))
        np.testing.assert_allclose(ply.read(served).xyz + content["origin"], [[1, 1, 1]])
    finally:
        server.terminate()
        server.communicate(timeout=20)
    assert server.returncode == 0
