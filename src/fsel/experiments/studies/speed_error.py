"""Speed against error: of the methods, of the reconstructor's settings, of the search."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace

import numpy as np
import pandas as pd

from fsel.core.files import File, Files, read_table, write_text
from fsel.evaluation import speed
from fsel.evaluation.latex import MISSING, plain_table
from fsel.evaluation.summary import write_csv
from fsel.evaluation.sweep import LABELS, sweep_cells
from fsel.experiments.studies.bench import benches, measure_cold, measure_model, measure_splats
from fsel.reconstruct.splats import SplatSettings
from fsel.training.search import fittest_so_far

logger = logging.getLogger(__name__)

COUNTS = (40, 100, 200, 300, 400)  # evaluations in the table
STEP = 10  # evaluations between points of a curve
PLANES = (8, 16, 32, 64, 96)
PARTNERS = (1, 2, 3, 4)
OPACITY = (0.0, 0.1, 0.25, 0.4, 0.6)
RESOLUTION = (0.5, 0.75, 1.0, 1.5, 2.0)  # of the configured longer side


def speed_error(
    times: File,
    settings: File,
    evaluations: Files,
    oracles: Files,
    subsets: Files,
    labels: Files,
    table: File,
    numbers: File,
    figures: Files,
    *,
    problems: Sequence[str],
    k: int,
) -> None:
    """Draw the figure of three panels and write the table of the same numbers.

    Args:
        times: what `fsel.experiments.studies.selection_time` wrote; its smallest pool is drawn.
        settings: what `speed_settings` wrote.
        evaluations, oracles: what `fsel.stages.evaluate` and `search_oracle` wrote, one a problem.
        subsets, labels: searched subsets, of those problems and of training scenes.
        table, numbers: receive LaTeX, and the numbers of every panel.
    """
    timed = pd.read_csv(times)
    timed = timed[timed["pool"] == timed["pool"].min()].set_index("method")
    cells = sweep_cells([*problems, *problems], [*evaluations, *oracles], facts={})
    methods = speed.gaps(cells[cells["k"] == k], reference="search", methods=list(timed.index))
    methods["seconds"] = methods["method"].map(timed["descriptors"] + timed["selection"])
    swept = pd.read_csv(settings, dtype={"value": str})
    curves = progress(subsets, labels)
    timed_k, pool = timed[["k", "pool"]].iloc[0]
    selected = f"{timed_k} of {pool} frames"
    speed.draw(methods, swept, curves, figures, selected=selected, k=k)
    every = pd.concat([methods, swept, curves], keys=["methods", "settings", "search"])
    every = every.droplevel(1).rename_axis("panel").reset_index()
    write_csv(every, numbers)
    write_text(_tables(methods, swept, curves, selected, k), table)


def progress(subsets: Files, labels: Files) -> pd.DataFrame:
    """Measure what stopping a search early costs.

    Args:
        subsets: searched subsets of evaluation problems, with a column `method`.
        labels: of training scenes.

    Returns:
        search, evaluations, generations, gap: mean PSNR in dB, on the proxies, of the fittest
        subset of the genetic search at its end minus that of the fittest after so many evaluations.
    """
    curves: dict[str, list[pd.DataFrame]] = {name: [] for name in speed.SEARCHES}
    for path in subsets:
        searches = read_table(path).groupby("method")
        for name, run in searches:
            curves[name].append(_behind(run, searches.get_group("search")))
    for path in labels:
        run = read_table(path)
        curves["labels"].append(_behind(run, run))
    tables = []
    for name, runs in curves.items():
        length = max(map(len, runs))
        at = np.unique(np.append(np.arange(STEP, length + 1, STEP), length))
        # a search that met fewer distinct subsets stays where it ended
        means = pd.concat([run.reindex(at, method="ffill") for run in runs]).groupby(level=0).mean()
        tables.append(means.rename_axis("evaluations").reset_index().assign(search=name))
    return pd.concat(tables, ignore_index=True)[["search", "evaluations", "generations", "gap"]]


def _behind(run: pd.DataFrame, whole: pd.DataFrame) -> pd.DataFrame:
    """Generations, and the gap to the fittest of another run, by the number of evaluations."""
    fittest, met = (
        each["psnr"].to_numpy()[fittest_so_far(each["fitness"].to_numpy())] for each in (whole, run)
    )
    table = {"generations": run["generation"].to_numpy(float), "gap": fittest[-1] - met}
    return pd.DataFrame(table, index=np.arange(1, len(run) + 1))


def _tables(
    methods: pd.DataFrame, swept: pd.DataFrame, curves: pd.DataFrame, selected: str, k: int
) -> str:
    of_methods = plain_table(
        ["Selection", "ms", "gap (dB)"],
        [
            [LABELS[row.method], f"{1e3 * row.seconds:,.3g}", f"{row.gap:.2f}"]
            for row in methods.sort_values("gap", kind="stable").itertuples()
        ],
        caption=rf"\textbf{{Speed against error: methods.}} Time to select {selected}, descriptors "
        rf"included, and PSNR behind the genetic search at $K={k}$.",
        label="tab:speed_methods",
    )
    of_settings = plain_table(
        ["Setting", "PSNR (dB)", r"depth error (\%)", "ms", "splats", "kB"],
        [_setting_row(row) for row in swept.itertuples()],
        caption=r"\textbf{Speed against error: the reconstructor.} One setting changed at a time; "
        rf"defaults in bold. {k} frames, nothing cached, one thread. Depth error: median over the "
        r"target views' pixels of $|z/z^\ast-1|$ against exact depth. Means over scenes.",
        label="tab:speed_settings",
    )
    searches = {"search": "Genetic search", "random_search": "Random search", "labels": "Labels"}
    of_search = plain_table(
        ["Search", *(f"{n} subsets" for n in COUNTS)],
        [
            [searches[name], *(_at(part.set_index("evaluations")["gap"], n) for n in COUNTS)]
            for name, part in curves.groupby("search", sort=False)
        ],
        caption=r"\textbf{Speed against error: the search.} PSNR in dB, on the proxies, that the "
        "fittest subset after so many evaluations lacks to the genetic search's at its end.",
        label="tab:speed_search",
    )
    return "\n".join([of_methods, of_settings, of_search])


def _setting_row(row) -> list[str]:
    name = f"{row.setting} {row.value.replace('-', '--')}"
    error = MISSING if np.isnan(row.depth_error) else f"{100 * row.depth_error:.1f}"
    return [
        rf"\textbf{{{name}}}" if row.default else name,
        f"{row.psnr:.2f}",
        error,
        f"{1e3 * row.seconds:.0f}",
        f"{row.primitives:,.0f}",
        f"{row.bytes / 1e3:,.0f}",
    ]


def _at(gaps: pd.Series, count: int) -> str:
    return f"{gaps[count]:.2f}" if count in gaps.index else MISSING


def speed_settings(
    folders: Files,
    splits: Files,
    numbers: File,
    *,
    generated: Sequence[Mapping | None],
    k: int,
    reconstruction: Mapping,
) -> None:
    """Measure the reconstructor with one setting changed at a time.

    Args:
        numbers: receives setting, value, default, and means over the problems of what
            `bench.measure_cold` returns, `seconds` being fit and rendering together.
        generated: see `bench.benches`.
        k: frames reconstructed from.
    """
    rows = []
    for place in benches(folders, splits, generated, k, reconstruction):
        usual, model = measure_splats(place, reconstruction)
        for setting, value, default, changes in settings_of(reconstruction, place.capture.size):
            cost = usual if default else measure_cold(place, reconstruction, **changes)[0]
            rows.append({"setting": setting, "value": value, "default": default, **cost})
        rounded = {"setting": "precision", "value": "float16", "default": False}
        halved = replace(model, splats=model.splats.astype(np.float16).astype(np.float32))
        rows.append(rounded | usual | measure_model(place, halved))
        logger.info("%r: %d settings", place.capture, len(rows))
    table = pd.DataFrame(rows)
    table["seconds"] = table.pop("fit_seconds") + table.pop("render_seconds")
    means = table.groupby(["setting", "value", "default"], sort=False).mean().reset_index()
    write_csv(means, numbers)


def settings_of(
    reconstruction: Mapping, size: tuple[int, int]
) -> Iterator[tuple[str, str, bool, dict]]:
    """(setting, printed value, whether it is the default, changes); no side is above the size's."""
    usual = asdict(SplatSettings(**reconstruction["settings"]))
    least, most = usual["planes"]
    for count in PLANES:
        yield "planes", str(count), False, {"planes": (count, count)}
    yield "planes", f"{least}-{most}", True, {}
    for setting, values in (("partners", PARTNERS), ("opacity", OPACITY)):
        for value in sorted({*values, usual[setting]}):
            yield setting, f"{value:g}", value == usual[setting], {setting: value}
    for share in RESOLUTION:
        side = round(share * reconstruction["long_side"])
        if side <= max(size):
            yield "resolution", str(side), share == 1, {"long_side": side}
    yield "precision", "float32", True, {}
