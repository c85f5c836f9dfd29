"""report.html, looked at in a real browser."""

import html
import re
import shlex
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from browsing import acted, decoded, looked_at, needs_a_browser, pictures
from selection_problems import capture_of
from small_captures import film, record_of, select, write_ring

from fsel.cli import main
from fsel.cli.select import AGAINST, without
from fsel.pages.report import WORLD, speeds, with_view
from fsel.pages.shown import _extent

MEASURE = """(() => {
const all = (query) => [...document.querySelectorAll(query)];
const lazy = all('.frame img').every((node) => node.loading === 'lazy');
const get = (id) => document.getElementById(id);
const key = (name) => document.body.dispatchEvent(
  new KeyboardEvent('keydown', { key: name, bubbles: true, cancelable: true }));
const canvas = document.querySelector('canvas');
const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
let inked = 0;
for (let i = 3; i < pixels.length; i += 4) inked += pixels[i] > 0;
canvas.focus();
const focused = document.activeElement === canvas;
const seen = {
  inked, focused, lazy,
  pictures: all('.frame img').length,
  kinds: all('.frame').map((node) => node.className.replace('frame ', '')),
  orders: all('.frame i').map((node) => +node.textContent),
  lanes: all('.lanes span').map((node) => node.textContent),
  picked: all('#picked tr').map((row) => [...row.cells].map((cell) => cell.textContent)),
  left: all('#left tr').map((row) => [...row.cells].map((cell) => cell.textContent)),
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  fetched: performance.getEntriesByType('resource').map((entry) => entry.name)
    .filter((name) => !name.startsWith('data:')),
};
all('.frame')[3].click();
seen.shown = [get('name').textContent, get('why').textContent,
  get('picture').src === all('.frame img')[3].src];
const edge = (at) => getComputedStyle(all('.frame')[at]).borderColor;
const unmarked = edge(3);
key('k');
seen.kept = [get('keep').getAttribute('aria-pressed'), edge(3) !== unmarked];
key('ArrowLeft'); key('d'); key('ArrowLeft');
seen.stepped = get('name').textContent;
get('drop').click(); get('drop').click();  // marked, and not
all('.frame')[0].click();
seen.fixed = get('keep').disabled;
key('k');  // a held-out frame cannot be kept
seen.command = get('command').textContent;
get('copy').click();
seen.copied = String(getSelection()).trim();
seen.inView = [0, document.body.scrollHeight / 2, document.body.scrollHeight].map((place) => {
  scrollTo(0, place);
  const { top, bottom } = get('command').getBoundingClientRect();
  return top >= 0 && bottom > top && bottom <= innerHeight;
});
seen.marked = all('.frame').map((node) => node.classList.contains('keep') ? 'keep'
  : node.classList.contains('drop') ? 'drop' : '');
const box = get('timeline').getBoundingClientRect();
get('timeline').dispatchEvent(new MouseEvent('click', { clientX: box.left + box.width * 0.99 }));
seen.last = get('name').textContent;
all('#filter input')[1].click();
seen.filtered = all('.frame:not([hidden])').length;
return seen;
})()"""
CLICKED = """(() => {
const canvas = document.querySelector('canvas'), box = canvas.getBoundingClientRect();
const names = new Set();
for (let x = 5; x < box.width; x += 10) for (let y = 5; y < box.height; y += 10) {
  canvas.dispatchEvent(new MouseEvent('click', { clientX: box.left + x, clientY: box.top + y }));
  names.add(document.getElementById('name').textContent);
}
return names.size;
})()"""

FLOWN = """
await view.ready;
document.querySelectorAll('.frame')[5].click();
const clicked = view.at;
const key = new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true });
view.element.dispatchEvent(key);
return [clicked, view.at, document.getElementById('name').textContent,
  document.querySelectorAll('canvas').length, document.querySelectorAll('.order').length];
"""


@pytest.fixture
def out(tmp_path, quick_trials):
    write_ring(tmp_path / "capture <b>&")
    arguments = ["-k", "7", "--targets", "every:8", "-o", str(tmp_path / "out")]
    assert main(["select", str(tmp_path / "capture <b>&"), *arguments]) == 0
    return tmp_path / "out"


def test_the_page_names_the_command_that_shows_it_in_a_scene(out):
    (said,) = re.findall("<code>(.*?)</code>", (out / "report.html").read_text())
    assert shlex.split(html.unescape(said)) == ["fsel", "view", str(out), "-o", f"{out}.html"]


@needs_a_browser
def test_with_the_viewer_frames_and_cameras_are_chosen_together(out, tmp_path):
    assert main(["view", str(out), "-o", str(tmp_path / "view.html")]) == 0
    page = (tmp_path / "view.html").read_text()
    assert acted(page, (1000, 800), FLOWN, tmp_path) == [5, 6, "frame_006.jpg", 1, 7]


def test_what_is_no_report_takes_no_viewer():
    for text in ("<html></html>", f"{WORLD}</figure>{WORLD}</figure>"):
        with pytest.raises(ValueError, match="no report of this version"):
            with_view(text, "")


@needs_a_browser
@pytest.mark.parametrize("width", [1280, 400])
def test_a_browser_shows_every_frame_and_takes_wishes(width, out, tmp_path):
    seen = looked_at(out / "report.html", width, MEASURE, tmp_path)
    content = record_of(out)
    names = [f"frame_{i:03d}.jpg" for i in range(24)]
    order = {entry["name"]: entry["order"] for entry in content["frames"]}
    assert seen["lazy"] is True
    assert seen["pictures"] == 24
    assert seen["inked"] > 2000
    assert seen["focused"] is True
    kinds = ["pick" if name in order else "left" for name in names]
    kinds[::8] = ["held"] * 3
    assert seen["kinds"] == kinds
    assert seen["orders"] == [order[name] for name in names if name in order]
    assert [text.partition(" ")[0] for text in seen["lanes"]] == ["speed", "exposure"]
    assert [row[:2] for row in seen["picked"]] == [
        [str(entry["order"]), entry["name"]] for entry in content["frames"]
    ]
    assert [
        f"shows {entry['sees_new']:.1%} of the" in row[2]
        for entry, row in zip(content["frames"], seen["picked"], strict=True)
    ] == [True] * 7
    assert seen["left"] == [[entry["name"], entry["reason"]] for entry in content["left"]]
    assert seen["overflow"] <= 0
    assert seen["fetched"] == []
    assert seen["shown"][0] == names[3]
    assert seen["shown"][2] is True
    assert seen["stepped"] == names[1]
    assert seen["fixed"] is True
    assert seen["marked"] == ["", "", "drop", "keep", *[""] * 20]
    assert seen["kept"] == ["true", True]
    assert seen["inView"] == [True] * 3
    assert seen["copied"] == seen["command"]
    assert seen["last"] == names[-1]
    assert seen["filtered"] == 7


def test_sharpness_has_a_lane_where_frames_show_enough(tmp_path):
    write_ring(tmp_path / "capture")
    film(tmp_path / "capture", {})
    select(tmp_path / "capture", "-k", 7, "-o", tmp_path / "out")
    assert ">sharpness: up to " in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@needs_a_browser
def test_the_command_of_the_page_does_as_it_says(out, tmp_path):
    seen = looked_at(out / "report.html", 1280, MEASURE, tmp_path)
    before = {entry["name"] for entry in record_of(out)["frames"]}
    assert main(shlex.split(seen["command"])[1:]) == 0
    edited = out.with_name("out_edit")
    after = {entry["name"] for entry in record_of(edited)["frames"]}
    assert after == (before | {"frame_003.jpg"}) - {"frame_002.jpg"} != before
    reasons = {entry["name"]: entry["reason"] for entry in record_of(edited)["left"]}
    assert reasons["frame_002.jpg"] == "excluded by never (--never)"
    marked = "[document.querySelectorAll('.keep, .drop').length, "
    marked += "document.querySelector('.lead').textContent]"
    count, lead = looked_at(edited / "report.html", 1280, marked, tmp_path)
    assert (count, "--always" in lead, "by fsel" in lead) == (1, True, False)


@needs_a_browser
def test_a_click_on_a_camera_shows_its_frame(out, tmp_path):
    assert looked_at(out / "report.html", 1280, CLICKED, tmp_path) > 18  # some hide others


def test_the_page_escapes_names_and_holds_its_pictures(out):
    page = (out / "report.html").read_text(encoding="utf-8")
    assert [image.shape for image in map(decoded, pictures(page))] == [(48, 64, 3)] * 24
    assert "capture &lt;b&gt;&amp;" in page
    assert "<b>&/" not in page


def test_geometry_only_leaves_the_pictures_out(tmp_path):
    write_ring(tmp_path / "capture")
    arguments = ["-k", "4", "--geometry-only", "-o", str(tmp_path / "out")]
    assert main(["select", str(tmp_path / "capture"), *arguments]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "data:image" not in page
    assert "exposure (" not in page
    assert page.count('<button class="frame') == 24


def test_a_turn_and_a_shift_make_the_speed():
    """Turned by 90 degrees, then moved by 3 at a depth of 1.8 times the spread, which is 2**0.5."""
    turned = np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])
    rotations = np.stack([np.eye(3), turned, turned, turned])
    capture = capture_of(np.array([[0.0, 0, 0], [0, 0, 0], [3, 0, 0], [1, 0, 0]]), rotations)
    capture = replace(capture.subset(np.arange(3)), sequences=("a", "a", "a"))
    moved = np.degrees(np.arctan(3 / (1.8 * np.sqrt(2))))
    np.testing.assert_allclose(speeds(SimpleNamespace(capture=capture)), [np.nan, 90, moved])
    other = replace(capture, sequences=("a", "b", "b"))
    np.testing.assert_allclose(speeds(SimpleNamespace(capture=other)), [np.nan, np.nan, moved])


@pytest.mark.parametrize(
    ("given", "left"),
    [
        ("select a -k 7 --always k.txt --ne=d.txt -o b --force", "select a"),
        ("select a -k7 --pati 3 --meth uniform", "select a"),
        ("select a -k auto --vram 8GB --trainer gsplat --quiet", "select a --quiet"),
        ("select a --max-error 1 --rate 2", "select a --max-error 1 --rate 2"),
    ],
)
def test_options_are_taken_out_of_a_command(given, left):
    assert without(given.split(), AGAINST) == left.split()


def test_points_far_away_do_not_make_one_dot_of_the_cameras():
    cameras = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    near = np.full((20, 3), 0.1)
    assert _extent(cameras, near)[0] == 1
    assert _extent(cameras, 100 * near + [50, 0, 0])[0] == 1.5
    assert _extent(cameras, near * 12 / np.sqrt(3) / 0.1 / 10)[0] == pytest.approx(1.2)
    assert _extent(np.zeros((3, 3)), np.full((4, 3), 2 / np.sqrt(3)))[0] == pytest.approx(2)
    assert _extent(np.zeros((3, 3)), np.empty((0, 3)))[0] == 1
    np.testing.assert_allclose(_extent(cameras + [5, 0, 0], near)[1], [5, 0, 0])
