"""report.html, looked at in a real browser."""

import json
import re

import cv2
import numpy as np
import pytest
from browsing import browse, looked_at, needs_a_browser
from small_captures import write_ring

from fsel.cli import main
from fsel.export.drawings import SHOWN, shown
from fsel.export.scene import _extent

MEASURE = """(() => {
const box = (node) => { const b = node.getBoundingClientRect(); return [b.width, b.height]; };
const all = (query) => [...document.querySelectorAll(query)];
const inked = (canvas) => {
  const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0;
  for (let i = 3; i < pixels.length; i += 4) count += pixels[i] > 0;
  return count;
};
const turned = (canvas) => {
  canvas.focus();
  const focused = document.activeElement === canvas;
  canvas.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft', cancelable: true }));
  return focused;
};
return {
  pictures: all('img').map((node) => [node.naturalWidth, node.naturalHeight]),
  drawings: all('svg').map(box),
  picks: all('.pick circle').map((node) => getComputedStyle(node).fill),
  orders: all('text.order').map((node) => node.textContent),
  targets: all('.target rect').length,
  frames: all('.frame circle').length,
  points: document.querySelector('polyline').getAttribute('points').split(' ').length,
  reasons: all('tbody tr').map((row) => row.innerText),
  captions: all('.sheet li').map((node) => node.innerText),
  letters: Math.min(...all('svg text').map((node) => box(node)[1])),
  inked: inked(document.getElementById('scene')),
  turned: turned(document.getElementById('scene')),
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  fetched: performance.getEntriesByType('resource').map((entry) => entry.name)
    .filter((name) => !name.startsWith('data:')),
};
})()"""


@pytest.fixture
def out(tmp_path):
    write_ring(tmp_path / "capture <b>&")
    arguments = ["-k", "7", "--targets", "every:8", "-o", str(tmp_path / "out")]
    assert main(["select", str(tmp_path / "capture <b>&"), *arguments]) == 0
    return tmp_path / "out"


@needs_a_browser
@pytest.mark.parametrize("width", [1280, 400])
def test_a_browser_shows_everything(width, out, tmp_path):
    page = (out / "report.html").read_text(encoding="utf-8")
    seen = looked_at(out / "report.html", width, MEASURE, tmp_path)
    assert seen["pictures"] == [[64, 48]] * 7
    assert seen["inked"] > 2000
    assert seen["turned"] is True
    assert len(seen["drawings"]) == 2
    assert all(min(size) > 100 for size in seen["drawings"])
    assert seen["letters"] > 9
    assert seen["picks"] == ["rgb(213, 94, 0)"] * 7
    assert sorted(seen["orders"], key=int) == [str(n) for n in range(1, 8)]
    assert (seen["targets"], seen["frames"], seen["points"]) == (3, 24, 8)
    assert seen["overflow"] <= 0
    assert seen["fetched"] == []
    content = json.loads((out / "selection.json").read_text())
    for caption, entry in zip(seen["captions"], content["frames"], strict=True):
        assert f"{entry['order']} {entry['name']}" in caption
        assert f"adds {entry['adds']:.1%}" in caption
    assert [row.split("\t") for row in seen["reasons"]] == [
        [entry["name"], entry["reason"]] for entry in content["left"]
    ]
    assert "capture &lt;b&gt;&amp;" in page


@needs_a_browser
def test_a_screenshot_shows_the_picks(out, tmp_path):
    target = tmp_path / "page.png"
    url = (out / "report.html").as_uri()
    browse(tmp_path, "--window-size=1240,1200", f"--screenshot={target}", url)
    image = cv2.imread(str(target)).astype(int)
    orange = (np.abs(image - [0, 94, 213]).max(axis=2) < 8).sum()
    assert orange > 7 * 100  # seven discs, a curve and a legend


def test_the_page_names_no_other_file(out):
    page = (out / "report.html").read_text(encoding="utf-8")
    sources = re.findall(r'(?:src|href)="([^"]{0,40})', page)
    assert sources
    assert all(source.startswith("data:image/jpeg;base64,") for source in sources)
    assert "@import" not in page
    assert "url(" not in page


def test_service_is_said_to_be_of_what_it_is_measured_at(out, tmp_path):
    assert "Service of the target views: " in (out / "report.html").read_text(encoding="utf-8")
    arguments = ["-k", "4", "--patience", "0", "-o", str(tmp_path / "any")]
    assert main(["select", str(tmp_path / "capture <b>&"), *arguments]) == 0
    page = (tmp_path / "any" / "report.html").read_text(encoding="utf-8")
    assert "Service of the whole capture, at 24 of its frames: " in page


def test_geometry_only_leaves_the_pictures_out(tmp_path):
    write_ring(tmp_path / "capture")
    arguments = ["-k", "4", "--geometry-only", "-o", str(tmp_path / "out")]
    assert main(["select", str(tmp_path / "capture"), *arguments]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<img" not in page
    assert "sharpness" not in page
    assert page.count("<li>") == 4


@pytest.mark.parametrize("count", [0, 1, 2, SHOWN, SHOWN + 1, 50_000])
def test_a_report_shows_at_most_so_many_evenly_spread(count):
    rows = shown(count)
    assert len(rows) == min(count, SHOWN)
    assert rows[:1] == [0][:count]
    assert rows[-1:] == [count - 1][:count]
    steps = np.diff(rows)
    assert not len(steps) or steps.max() - steps.min() <= 1


def test_points_far_away_do_not_make_one_dot_of_the_cameras():
    cameras = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    near = np.full((20, 3), 0.1)
    assert _extent(cameras, near)[0] == 1
    assert _extent(cameras, 100 * near + [50, 0, 0])[0] == 1.5
    assert _extent(cameras, near * 12 / np.sqrt(3) / 0.1 / 10)[0] == pytest.approx(1.2)
    assert _extent(np.zeros((3, 3)), np.full((4, 3), 2 / np.sqrt(3)))[0] == pytest.approx(2)
    assert _extent(np.zeros((3, 3)), np.empty((0, 3)))[0] == 1
    np.testing.assert_allclose(_extent(cameras + [5, 0, 0], near)[1], [5, 0, 0])
