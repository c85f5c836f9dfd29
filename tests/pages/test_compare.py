"""compare.html, looked at in a real browser; its intervals by hand."""

import json

import numpy as np
import pytest
from browsing import decoded, looked_at, needs_a_browser, pictures
from small_captures import write_ring

from fsel.cli import main
from fsel.metrics import REGISTERED
from fsel.pages.compare import Compared, differences, verdict

SHARP = np.zeros(3, bool)
MEASURE = """(() => {
const all = (query) => [...document.querySelectorAll(query)];
const get = (id) => document.getElementById(id);
const cards = () => all('.card:not([hidden])');
const choose = (name, at) => all(`#${name} input`)[at].click();
const clips = () => [...new Set(all('.over').map((over) => getComputedStyle(over).clipPath))];
const labels = () => cards().map((card) => card.querySelector('b').textContent);
const order = () => all('.versus h3').map((node) => node.textContent.split(',')[0]);
const seen = {
  cells: all('tbody tr').map((row) => [...row.cells].map((cell) => cell.innerText)),
  sentences: all('.verdict').map((node) => node.innerText),
  tops: all('.versus').map((row) => new Set([...row.querySelectorAll('.card:not([hidden])')]
    .map((card) => card.getBoundingClientRect().top)).size),
  tall: Math.max(...all('.pair').map((pair) => pair.getBoundingClientRect().height)),
  shapes: cards().map((card) => card.querySelector('.pair').getBoundingClientRect())
    .map((box) => box.width / box.height),
  captions: all('.card:not([hidden]) figcaption').map((node) => node.innerText),
  covered: all('.over').filter((over) => over.src === over.closest('.versus')
    .querySelector('.truth img').src && over.src.length > 400).length,
  lines: all('.chart polyline').length,
  intervals: all('.chart g path').length, legend: all('.legend span').map((node) => node.innerText),
  first: labels(), time: order(), before: clips(),
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  fetched: performance.getEntriesByType('resource').map((entry) => entry.name)
    .filter((name) => !name.startsWith('data:')),
};
get('slider').focus();
seen.reached = document.activeElement === get('slider');
get('slider').value = 20;
get('slider').dispatchEvent(new Event('input'));
seen.after = clips();
const pair = document.querySelector('.card:not([hidden]) .pair');
const box = pair.getBoundingClientRect();
pair.dispatchEvent(new PointerEvent('pointerdown', { clientX: box.left + 0.75 * box.width }));
seen.dragged = +get('slider').value;
choose('order', 1);
seen.worst = order();
choose('budget', 1);
seen.second = labels();
choose('view', 1);
seen.blend = getComputedStyle(document.querySelector('.over')).mixBlendMode;
return seen;
})()"""


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compared")
    write_ring(folder / "capture <b>&")
    asked = ["compare", str(folder / "capture <b>&"), "-k", "4,5", "--methods", "fsel,uniform"]
    asked += ["--long-side", "48", "--reconstructor", "splats", "-o", str(folder / "out")]
    assert main(asked) == 0
    return folder / "out"


@needs_a_browser
@pytest.mark.parametrize("width", [1280, 400])
def test_a_browser_shows_every_rendering(width, out, tmp_path):
    seen = looked_at(out / "compare.html", width, MEASURE, tmp_path)
    content = json.loads((out / "compare.json").read_text())
    assert seen["sentences"] == [content["verdict"]]
    methods = ["fsel select --targets --patience 0", "uniform"]
    rows = [[k, name] for k in ("4", "5") for name in methods]
    assert [cells[:2] for cells in seen["cells"]] == rows
    for cells, row in zip(seen["cells"], content["rows"], strict=True):
        assert cells[2].startswith(f"{row['psnr']:.2f} (")
    assert seen["tops"] == [1] * 3  # methods of a frame in one row
    assert seen["tall"] <= 0.72 * 1200 + 1
    assert seen["shapes"] == pytest.approx([4 / 3] * 6, rel=0.01)
    assert (seen["lines"], seen["intervals"], seen["legend"]) == (2, 4, methods)
    assert seen["first"] == [f"{name}, K = 4" for name in methods] * 3
    assert seen["time"] == content["targets"]
    assert all("PSNR" in text and "SSIM" in text for text in seen["captions"])
    assert seen["covered"] == 12
    clips = [["inset(0px 50% 0px 0px)"], ["inset(0px 80% 0px 0px)"]]
    assert [seen["before"], seen["after"]] == clips
    assert seen["reached"] is True
    assert seen["dragged"] == pytest.approx(75, abs=0.5)
    assert sorted(seen["worst"]) == sorted(seen["time"])
    psnr = [float(text.split("PSNR ")[1].split(" dB")[0]) for text in seen["captions"][::2]]
    assert seen["worst"] == [seen["time"][at] for at in np.argsort(psnr, kind="stable")]
    assert seen["second"] == [f"{name}, K = 5" for name in methods] * 3
    assert seen["blend"] == "difference"
    assert seen["overflow"] <= 0
    assert seen["fetched"] == []


def test_the_page_escapes_names_and_holds_its_pictures(out):
    page = (out / "compare.html").read_text(encoding="utf-8")
    images = [decoded(picture) for picture in pictures(page)]
    assert [image.shape for image in images] == [(36, 48, 3)] * 15  # 3 frames, 4 renderings each
    assert min(len(np.unique(image)) for image in images[::5]) > 20  # no held-out frame is blank
    assert "capture &lt;b&gt;&amp;" in page
    assert "<b>&/" not in page
    content = json.loads((out / "compare.json").read_text())
    text = (out / "compare.txt").read_text()
    assert content["verdict"] in text
    for row in content["rows"]:  # the page and the text print the same digits
        for name in ("psnr", "ssim", "gmsd"):
            assert REGISTERED[name].printed(row[name]) in text
            printed = REGISTERED[name].printed(row[name])
            assert f"<td>{printed}" in page or f"<td><mark>{printed}</mark>" in page


def scores(*psnr):
    return np.column_stack([psnr, np.zeros(len(psnr))])


def of_two(*pairs, blurred=(False,) * 3):
    """A comparison of a and b: for each k their PSNR on the frames."""
    found = {(k, "ab"[i]): scores(*pair[i]) for k, pair in enumerate(pairs) for i in (0, 1)}
    used = {(k, name): k for k, name in found}
    at = np.array(blurred[: len(pairs[0][0])])
    shown = tuple("wxyz"[: len(at)])
    return Compared("c", "", shown, ("psnr", "ssim"), found, used, (), [], {}, at)


def test_the_best_of_as_many_frames_is_marked():
    compared = of_two(((11, 22, 33), (10, 20, 30)), ((9, 9, 9), (10, 20, 30)))
    best = [(cell, compared.is_best(cell, 0)) for cell in compared.scores]
    assert best == [((0, "a"), True), ((0, "b"), False), ((1, "a"), False), ((1, "b"), True)]


def test_differences_are_paired_by_frame():
    """1, 2 and 3 dB: mean 2, error 1 / sqrt(3), times Student's 4.303 for two degrees."""
    compared = of_two(((11, 22, 33), (10, 20, 30)))
    (entry,) = differences(compared)
    half = 4.302653 / np.sqrt(3)
    assert entry["psnr"] == 2
    assert [entry["ci_low"], entry["ci_high"]] == pytest.approx([2 - half, 2 + half], abs=1e-4)
    assert (entry["k"], entry["method"], entry["than"], entry["n"]) == (0, "a", "b", 3)
    lead = f"a is 2.00 dB ahead of b ({2 - half:+.2f} to {2 + half:+.2f})"
    assert verdict(compared).startswith(lead)
    swapped = verdict(of_two(((10, 20, 30), (11, 22, 33))))
    assert swapped.startswith(lead.replace("ahead of", "behind"))


def test_one_sentence_counts_what_is_beyond_chance():
    ahead, behind = ((11, 21, 31.1), (10, 20, 30)), ((9, 19, 28.9), (10, 20, 30))
    said = verdict(of_two(ahead, behind, ahead, ((10, 20, 31), (10, 20, 30))))
    assert said.startswith("a is significantly better in 2 and worse in 1 of 4 comparisons (95")


def test_of_two_frames_there_is_no_interval():
    compared = of_two(((11, 21), (10, 20)))
    (entry,) = differences(compared)
    assert (entry["psnr"], entry["ci_low"], entry["ci_high"], entry["n"]) == (1, None, None, 2)
    said = "a is ahead in 1 of 1 comparison, over 2 held-out frames: too few for an interval."
    assert verdict(compared) == said


def test_blurred_frames_are_told_apart():
    """2, 3 and 4 dB on sharp frames: mean 3, error 1 / sqrt(3), times Student's 4.303."""
    pair = ((12, 10, 33, 44), (10, 20, 30, 40))
    compared = of_two(pair, blurred=(False, True, False, False))
    (entry,) = differences(compared)
    assert (entry["psnr"], entry["n"]) == (pytest.approx(-0.25), 4)
    assert (entry["sharp"]["psnr"], entry["sharp"]["n"]) == (3, 3)
    assert entry["sharp"]["ci_high"] == pytest.approx(3 + 4.302653 / np.sqrt(3), abs=1e-4)
    assert "3.00 dB ahead of b (+0.52 to +5.48)" in verdict(compared)


@pytest.mark.parametrize("blurred", [[False] * 3, [True, True, False], [True] * 3])
def test_nothing_is_said_of_too_few_sharp_frames(blurred):
    compared = of_two(((12, 10, 34), (10, 20, 30)), blurred=blurred)
    (entry,) = differences(compared)
    assert "sharp" not in entry
    assert "blurred" not in verdict(compared)


def test_every_frame_is_one_row_and_the_last():
    found = {(k, name): scores(1, 2, 3) for k in (4, 5) for name in ("all", "a")}
    used = {(k, name): 70 if name == "all" else k for k, name in found}
    compared = Compared("c", "", ("x", "y", "z"), ("psnr", "ssim"), found, used, (), [], {}, SHARP)
    assert compared.rows == {(4, "a"): [4], (5, "a"): [5], (70, "all"): [4, 5]}
    alone = Compared("c", "", ("x",), ("psnr",), {(4, "a"): scores(1)}, {}, (), [], {}, SHARP[:1])
    assert verdict(alone) == "a has no other method to compare with."
