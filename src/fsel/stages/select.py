"""Run every method on a problem, and measure what its selections are worth."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.baselines import METHODS
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import fingerprint, write_table
from fsel.metrics import METRICS, score_views
from fsel.problem import Method, Problem, checked_select
from fsel.reconstruct import Reconstructor
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Scorer
from fsel.stages.journal import Journal
from fsel.stages.label import (
    METRIC_UNITS,
    name_seed,
    reconstructor_of,
    search_subsets,
    search_table,
)
from fsel.stages.split import load_problem, split_from

logger = logging.getLogger(__name__)

SELECTION_UNITS = {"seconds": "s, of the whole run that these picks are a prefix of"}
EVALUATION_UNITS = {**METRIC_UNITS, "fit_seconds": "s", "render_seconds": "s", "bytes": "bytes"}


def select(
    folder: str | Path,
    splits: Sequence[str | Path],
    weights: Mapping[str, Sequence[str | Path]],
    outputs: Sequence[str | Path],
    *,
    budgets: Sequence[int],
    seeds: Sequence[int],
    config: str,
) -> None:
    """Every method's picks at every budget of every draw, one row a pick.

    Args:
        folder: a canonical capture with its descriptors.
        splits: split.parquet, one a draw.
        weights: learned method -> its scorers, one a training seed.
        outputs: one a draw: method, pool, seed, k, order, frame, name, seconds; `pool` is where the
            method may pick from, `candidates` (P) or `observed` (P and O).
        budgets: frames to pick.
        seeds: one a draw.
        config: digest of the parameters.
    """
    runs = [(method, s) for method in METHODS.values() for s in range(method.seeds)]
    for name, paths in weights.items():
        runs += [(POLICIES[name].method(Scorer.load(p)), s) for s, p in enumerate(paths)]
    for split, output, seed in zip(splits, outputs, seeds, strict=True):
        problem = load_problem(folder, split)
        rows = [picks for method, s in runs for picks in _picks(problem, method, s, budgets, seed)]
        write_table(pd.concat(rows), output, units=SELECTION_UNITS, config=config)


def _picks(
    problem: Problem, method: Method, number: int, budgets: Sequence[int], seed: int
) -> list[pd.DataFrame]:
    """One table a budget; a nested method runs once, at the largest."""
    if method.name == "all":
        budgets = [len(problem.observed)]
    asked = [max(budgets)] if method.nested else budgets
    runs = {}
    for k in asked:
        rng = np.random.default_rng(name_seed(seed, method.name, number, k))
        started = time.perf_counter()
        picks = checked_select(method, problem, k, rng)
        runs[k] = picks, time.perf_counter() - started
    tables = []
    for k in budgets:
        picks, seconds = runs[max(asked) if method.nested else k]
        head = {"method": method.name, "pool": method.pool, "seed": number, "k": k}
        table = pd.DataFrame({**head, "order": range(k)})
        table["frame"] = picks[:k]
        table["name"] = [problem.capture.names[frame] for frame in picks[:k]]
        tables.append(table.assign(seconds=seconds))
    return tables


class _Measure:
    """Measures subsets on target views, each distinct one once."""

    def __init__(self, reconstructor: Reconstructor, targets: np.ndarray) -> None:
        self.reconstructor, self.targets = reconstructor, targets
        self.views = reconstructor.capture.view(targets)
        self.truth = np.asarray(reconstructor.capture.images[targets])
        self._known: dict[tuple[int, ...], pd.DataFrame] = {}

    def __call__(self, frames: np.ndarray) -> pd.DataFrame:
        """One row a target."""
        key = tuple(np.sort(frames).tolist())
        if key not in self._known:
            self._known[key] = self._measured(np.array(key))
        return self._known[key]

    def _measured(self, frames: np.ndarray) -> pd.DataFrame:
        model = self.reconstructor.fit(frames)
        started = time.perf_counter()
        rendered = model.render(self.views)
        rendering = time.perf_counter() - started
        table = pd.DataFrame({"target": self.targets})
        table[list(METRICS)] = score_views(rendered, self.truth)
        return table.assign(
            fit_seconds=model.seconds,
            render_seconds=rendering,
            primitives=model.primitives,
            bytes=model.bytes,
        )


def evaluate(
    folder: str | Path,
    splits: Sequence[str | Path],
    selections: Sequence[str | Path],
    outputs: Sequence[str | Path],
    *,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Reconstruct every selection and compare it with the held-out targets of its draw.

    The draws share one reconstructor, and with it the matching costs that they have in common.

    Args:
        folder: a canonical capture.
        splits: split.parquet, one a draw.
        selections: what `select` wrote, one a draw.
        outputs: one a draw: method, seed, k, target, metrics and costs.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    for draw, (split, picked, output) in enumerate(zip(splits, selections, outputs, strict=True)):
        measure = _Measure(reconstructor, split_from(pd.read_parquet(split)).targets)
        tables = []
        for (method, s, k), picks in pd.read_parquet(picked).groupby(["method", "seed", "k"]):
            measured = measure(picks["frame"].to_numpy(np.int64))
            tables.append(_labelled(measured, method, s, k))
            psnr = measured["psnr"].mean()
            logger.info("draw %d, %s seed %d k %d: %.2f dB", draw, method, s, k, psnr)
        write_table(pd.concat(tables), output, units=EVALUATION_UNITS, config=config)


def _labelled(measured: pd.DataFrame, method: str, seed: int, k: int) -> pd.DataFrame:
    head = pd.DataFrame({"method": method, "seed": seed, "k": k}, index=measured.index)
    return pd.concat([head, measured], axis=1)


def search_oracle(
    folder: str | Path,
    split: str | Path,
    subsets: str | Path,
    output: str | Path,
    *,
    search: Mapping,
    reconstruction: Mapping,
    seed: int,
    inputs: Iterable[str | Path],
    config: str,
) -> None:
    """The genetic search on an evaluation problem, and random search of equal budget beside it.

    Both score subsets on the proxies and are then measured on the targets (Appendix D.3).

    Args:
        folder: a canonical capture with its descriptors.
        split: split.parquet of the draw.
        subsets, output: receive every subset, on the proxies, and the best two, on the targets.
        search, reconstruction: the config's sections.
        seed: of the draw.
        inputs, config: files and digest of parameters that the evaluations depend on.
    """
    problem, parts = load_problem(folder, split), split_from(pd.read_parquet(split))
    reconstructor = reconstructor_of(problem.capture, reconstruction)
    measure = _Measure(reconstructor, parts.targets)
    searched, measured = [], []
    with Journal(subsets, fingerprint(inputs, {"config": config})) as journal:
        on_proxies = journal.remember("p", Evaluator.on_frames(reconstructor, parts.proxies))
        for name, labeller in (("search", "genetic"), ("random_search", "random")):
            rng = np.random.default_rng([seed, name_seed(name)])
            result = search_subsets(on_proxies, problem, parts, labeller, search, rng)
            search = {**search, "evaluations": len(result.subsets)}
            searched.append(search_table(result, search["stored"]).assign(method=name))
            fittest = measure(result.subsets[result.best(1)[0]])
            measured.append(_labelled(fittest, name, 0, search["k"]))
        write_table(pd.concat(measured), output, units=EVALUATION_UNITS, config=config)
        write_table(pd.concat(searched), subsets, units=METRIC_UNITS, config=config)
