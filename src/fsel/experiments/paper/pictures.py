"""Rendered views of several selections beside the truth: of each dataset, of the full sequence, and
of one capture from others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table
from fsel.core.subsets import evenly
from fsel.evaluation.figures import (
    COLORS,
    TEXT,
    draw_cameras,
    footnote,
    new_figure,
    plan_positions,
    save,
)
from fsel.evaluation.latex import note
from fsel.evaluation.summary import write_csv
from fsel.experiments.studies.footprint import fit_and_render
from fsel.metrics import METRICS, score_views
from fsel.reconstruct import needs_gpu, reconstructor_of
from fsel.selection.frames import frames_of
from fsel.selectors.baselines import METHODS, PAPER
from fsel.selectors.policies import POLICIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

LABELS = {name: m.label for name, m in METHODS.items()} | {
    name: policy.label for name, policy in POLICIES.items()
}
STRONGEST = "strongest"  # stands for a baseline, see `resolved`
VIEWED = ("all", "uniform", STRONGEST, "less_is_more", "fsel")
WARM_FRAMES, WARM_SIDE = 4, 32  # of a reconstruction that only compiles
PIXELS = 384  # of an image's longer side, in what is saved
INSET = 0.34  # of an image's sides
WORST = 0.2  # mean absolute error that the brightest colour of an inset stands for
ERRORS = "inferno"


def qualitative(
    folder: File,
    split: File,
    selections: File,
    evaluations: Files,
    figures: Files,
    numbers: File,
    *,
    facts: Mapping,
    views: int,
    k: int,
    reconstruction: Mapping,
    methods: Sequence[str] = VIEWED,
) -> None:
    """Draw held-out views rendered from each method's first seed, and its cameras from above;
    `folder` has images large enough, the other arguments are of `draw_views`."""
    capture, roles = Capture.load(folder), read_table(split)
    targets = frames_of(capture, roles[roles["role"] == "target"]["name"].tolist())
    evaluation = pd.concat([read_table(path) for path in evaluations])
    picked = read_table(selections).query("seed == 0")
    shown: dict[str, Any] = {"k": k, "views": views, "methods": methods}
    shown |= {"reconstruction": reconstruction, "note": note(facts)}
    draw_views(capture, picked, evaluation, targets, figures, numbers, **shown)


def real_world(
    folder: File,
    selected_from: File,
    picks: File,
    evaluation: File,
    figures: Files,
    numbers: File,
    *,
    facts: Mapping,
    views: int,
    k: int,
    reconstruction: Mapping,
    methods: Sequence[str] = VIEWED,
) -> None:
    """Draw targets of the first sequence, rendered from what methods picked among the others.

    Names connect `folder`, whose images are large enough, with `selected_from`, the frames.parquet
    of the capture selected from; `picks` and `evaluation` are of `crosscapture.TRIALS`.
    """
    capture = Capture.load(folder)
    every = read_table(evaluation).query("draw == 0")
    passes = set(every["held_out"])
    held_out = next(name for name in capture.sequences if name in passes)
    measured = every.query("held_out == @held_out")
    names = read_table(selected_from)["name"]
    targets = frames_of(capture, names[np.unique(measured["target"])].tolist())
    # of a sequence split, no held-out pass is selected from
    rest = set(capture.sequences) - passes or set(capture.sequences) - {held_out}
    others = [n for n, of in zip(capture.names, capture.sequences, strict=True) if of in rest]
    picked = read_table(picks).query("held_out == @held_out and draw == 0 and seed == 0")
    all_others = pd.DataFrame({"method": "all", "name": others, "order": range(len(others))})
    picked = pd.concat([picked, all_others])
    text = f"Views of {held_out}, frames of {len(rest)} other captures of it. {note(facts)}"
    shown: dict[str, Any] = {"k": k, "views": views, "methods": methods}
    shown |= {"reconstruction": reconstruction, "note": text}
    draw_views(capture, picked, measured, targets, figures, numbers, **shown)


@dataclass(frozen=True)
class Shown:
    """One selection's column: title, (T, h, w, 3) float32 renderings in [0, 1], (T,) PSNR in dB."""

    title: str
    rendered: np.ndarray
    psnr: np.ndarray
    frames: np.ndarray


def resolved(methods: Sequence[str], evaluation: pd.DataFrame, k: int) -> list[str]:
    """Return the methods with `STRONGEST` replaced by the best other baseline of the paper."""
    if STRONGEST not in methods:
        return list(methods)
    external = [name for name in PAPER if name not in {*methods, "untrained"}]
    rivals = evaluation[(evaluation["k"] == k) & evaluation["method"].isin(external)]
    if rivals.empty:
        raise ValueError(f"no baseline of {external} was evaluated at a budget of {k}")
    strongest = str(rivals.groupby("method")["psnr"].mean().idxmax())
    return [strongest if name == STRONGEST else name for name in methods]


def draw_views(
    capture: Capture,
    picked: pd.DataFrame,
    evaluation: pd.DataFrame,
    targets: np.ndarray,
    figures: Files,
    numbers: File,
    *,
    views: int,
    k: int,
    reconstruction: Mapping,
    note: str,
    methods: Sequence[str],
) -> None:
    """Draw targets rendered from each selection, with its cameras from above below them.

    Args:
        picked: method, k, order, name of one seed; frames are found in the capture by their names.
        targets: (T,) held-out frames, of which `views` evenly spaced ones are drawn.
        numbers: receives what is drawn; x and y in world units.
        methods: columns, in order; `strongest` is the best other baseline of the paper at k.
    """
    places, drawn = plan_positions(capture), spaced(len(targets), views)
    tiny = reconstructor_of(capture, {**reconstruction, "long_side": WARM_SIDE})
    tiny.fit(targets[:WARM_FRAMES]).render(tiny.capture.view(targets[:1]))
    columns, tables, gpu = [], [], needs_gpu(reconstruction)
    for method in resolved(methods, evaluation, k):
        frames = frames_of(capture, picks_of(picked, method, k))
        fresh = reconstructor_of(capture, reconstruction)  # it has cached nothing yet
        targeted = fresh.capture.view(targets)
        rendered, _, *taken = fit_and_render(fresh, np.sort(frames), targeted, gpu)
        scores = score_views(rendered, np.asarray(fresh.capture.images[targets]))
        seconds = sum(taken)
        cost = f"{len(frames)} frames, {seconds:.1f} s"
        title = f"{LABELS[method]}\n{cost}\nmean {scores[:, 0].mean():.2f} dB"
        columns.append(Shown(title, rendered[drawn], scores[drawn, 0], frames))
        table = _cameras(frames, targets, scores, places)
        tables.append(table.assign(method=method, k=len(frames), seconds=seconds))
    order = ["method", "k", "seconds", "role", "frame", "x", "y", *METRICS]
    write_csv(pd.concat(tables)[order], numbers)
    small = capture.resized(reconstruction["long_side"])
    truth = np.asarray(small.images[targets[drawn]])
    text = (
        "Heading: frames, processor seconds to reconstruct and to render "
        f"{len(targets)} held-out views, their mean PSNR. Inset: mean absolute error of the "
        "colours. Below: cameras from above, selected ones as large dots, held-out views as "
        f"diamonds. {note}"
    )
    draw(truth, columns, places, targets, figures, text)


def spaced(count: int, views: int) -> np.ndarray:
    """(views,) evenly spaced numbers below `count`, ends included; one is the middle one."""
    return np.array([count // 2]) if views == 1 else evenly(count, views)


def _cameras(
    frames: np.ndarray, targets: np.ndarray, scores: np.ndarray, places: np.ndarray
) -> pd.DataFrame:
    held_out = pd.DataFrame({"role": "target", "frame": targets})
    held_out[list(METRICS)] = scores
    table = pd.concat([held_out, pd.DataFrame({"role": "selected", "frame": frames})])
    table[["x", "y"]] = places[table["frame"]]
    return table


def picks_of(picked: pd.DataFrame, method: str, k: int) -> list[str]:
    """Names of a method's frames at a budget, in order; of `all`, every frame's."""
    part = picked[picked["method"] == method]
    part = part if method == "all" else part[part["k"] == k]
    return part.sort_values("order")["name"].tolist()


def draw(
    truth: np.ndarray,
    columns: Sequence[Shown],
    places: np.ndarray,
    targets: np.ndarray,
    outputs: Sequence[str | Path],
    note: str,
) -> None:
    """Draw rows of (T, h, w, 3) uint8 targets, then the selected of (N, 2) cameras in plan view;
    columns are the truth and the selections, each rendered image with its error in a corner."""
    rows, (height, width) = len(truth), truth.shape[1:3]
    wide = TEXT / (len(columns) + 1)
    row = wide * height / width + 0.16
    size = (TEXT, rows * row + wide + 0.75)
    figure = new_figure(size)
    axes = figure.subplots(
        rows + 1, len(columns) + 1, squeeze=False, height_ratios=[row] * rows + [wide]
    )
    for y in range(rows):
        _image(axes[y, 0], truth[y] / 255)
        # mean absolute differences of the three colours, in 0..1
        errors = [np.abs(one.rendered[y] - truth[y] / 255.0).mean(axis=-1) for one in columns]
        place = _calmest(np.mean(errors, axis=0))
        for x, (column, error) in enumerate(zip(columns, errors, strict=True), 1):
            _image(axes[y, x], np.clip(column.rendered[y], 0, 1))
            axes[y, x].set_xlabel(f"{column.psnr[y]:.2f} dB", fontsize=7, labelpad=2)
            inset = axes[y, x].inset_axes((*place, INSET, INSET))
            shown = _image(inset, error, cmap=ERRORS, vmin=0, vmax=WORST)
            inset.spines[:].set_color("white")
    axes[0, 0].set_title("held-out view", fontsize=7)
    axes[rows, 0].axis("off")
    scale = axes[rows, 0].inset_axes((0.1, 0.6, 0.8, 0.06))
    figure.colorbar(shown, cax=scale, orientation="horizontal", ticks=[0, WORST])
    scale.set_title("error (inset)", fontsize=7)
    scale.tick_params(labelsize=7)
    for x, column in enumerate(columns, 1):
        axes[0, x].set_title(column.title, fontsize=7)
        draw_cameras(axes[rows, x], places, targets, 3.0)
        axes[rows, x].plot(*places[column.frames].T, "o", color=COLORS[0], markersize=3, zorder=2)
    footnote(figure, note)
    save(figure, outputs, round(PIXELS / (wide * max(1, height / width))))


def _image(axis: Axes, image: np.ndarray, **colors: Any) -> AxesImage:
    axis.set_xticks([])
    axis.set_yticks([])
    return axis.imshow(image, interpolation="antialiased", **colors)


def _calmest(error: np.ndarray) -> tuple[float, float]:
    """Lower left end, as shares of the sides, of the inset in the corner with the least error."""
    high, wide = (round(INSET * side) for side in error.shape)
    rows = {0.0: slice(-high, None), 1 - INSET: slice(high)}  # rows of an image count from above
    columns = {0.0: slice(wide), 1 - INSET: slice(-wide, None)}
    return min(product(columns, rows), key=lambda at: error[rows[at[1]], columns[at[0]]].mean())
