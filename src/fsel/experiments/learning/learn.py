"""Learn from labelled requests, in every way and with every set of inputs."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import torch

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.experiments.ablation.trials import parameters
from fsel.experiments.learning import practice, teaching
from fsel.experiments.learning.cases import EVERY, INPUT_CASES, LEARNERS
from fsel.experiments.learning.lessons import Lesson, lessons
from fsel.experiments.learning.network import Learned, load, save
from fsel.experiments.learning.practice import Judge
from fsel.files import read_table, write_table
from fsel.reconstruct import reconstructor_of
from fsel.split import Split

logger = logging.getLogger(__name__)

METRIC = ("psnr",)
UNITS = {"seconds": "s of processor time, of all seeds"}


def _keep(network: Learned, given: Sequence[Lesson], settings: Mapping, seed: int) -> None:
    """Nothing is learned: the networks of the start are used in another way."""


TAUGHT: dict[str, Callable[[Learned, Sequence[Lesson], Mapping, int], None]] = {
    "imitate": teaching.imitate,
    "dagger": teaching.dagger,
    "rank": teaching.rank,
    "rank_swaps": teaching.rank_swaps,
    "keep": _keep,
}
PRACTISED: dict[str, Callable[[Learned, Sequence[Lesson], Judge, Mapping, int], None]] = {
    "gradient": practice.policy_gradient,
    "evolve": practice.evolve,
}
"""Of the same, with reconstructions that judge."""


def learn(
    folders: Sequence[str | Path],
    labels: Sequence[str | Path],
    splits: Sequence[str | Path],
    networks: str | Path,
    log: str | Path,
    *,
    start: Sequence[str | Path],
    learner: str,
    settings: Mapping,
    practised: Sequence[int],
    reconstruction: Mapping,
    config: str,
) -> None:
    """One learner, once a seed: 0, 1, ...

    Args:
        folders: canonical captures with their descriptors, one a scene.
        labels, splits: what `fsel.stages.label_requests` wrote of each.
        networks: receives them, see `fsel.experiments.learning.network.save`.
        log: receives learner, seeds, lessons, subsets, parameters, seconds.
        start: networks of the learner that it goes on from, if any.
        learner: key of `LEARNERS`.
        settings: the config's section, and learning_rate.
        practised: numbers of the scenes that are reconstructed for learners that practise.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    way = LEARNERS[learner]
    given = list(lessons(folders, labels, splits))
    begun = load(start[0])[str(way.start)] if start else []
    started, made = time.process_time(), []
    for seed in range(settings["seeds"]):
        torch.manual_seed(seed)
        network = begun[seed] if begun else Learned(EVERY, way.on_rule)
        if way.how in PRACTISED:
            judge = judge_of(folders, splits, practised, reconstruction)
            met = [lesson for lesson in given if lesson.place[0] in practised]
            PRACTISED[way.how](network, met, judge, settings, seed)
        else:
            TAUGHT[way.how](network, given, settings, seed)
        made.append(network)
        logger.info("%s, seed %d: %.1f s", learner, seed, time.process_time() - started)
    save({learner: made}, networks)
    record = _record(learner, given, made, time.process_time() - started)
    write_table(pd.DataFrame([record]), log, units=UNITS, config=config)


def learn_inputs(
    folders: Sequence[str | Path],
    labels: Sequence[str | Path],
    splits: Sequence[str | Path],
    networks: str | Path,
    log: str | Path,
    *,
    settings: Mapping,
    config: str,
) -> None:
    """Networks alone, imitating the same labels with every set of inputs; arguments as `learn`."""
    given = list(lessons(folders, labels, splits))
    found, records = {}, []
    taught = teaching.all_taught(given, settings, 0)
    for name, case in INPUT_CASES.items():
        started, made = time.process_time(), []
        for seed in range(settings["seeds"]):
            torch.manual_seed(seed)
            made.append(Learned(case.groups, on_rule=False))
            teaching.fit(made[-1], taught, teaching.any_of, settings, seed)
        found[name] = made
        records.append(_record(name, given, made, time.process_time() - started))
        logger.info("%s", records[-1])
    save(found, networks)
    write_table(pd.DataFrame(records), log, units=UNITS, config=config)


def judge_of(
    folders: Sequence[str | Path],
    splits: Sequence[str | Path],
    practised: Sequence[int],
    reconstruction: Mapping,
) -> Judge:
    """PSNR of picks on the targets of their lesson; each scene has one reconstructor.

    Args:
        folders, splits: see `learn`.
        practised: scenes whose lessons will be judged.
        reconstruction: the config's section.
    """
    evaluators: dict[tuple[int, int], Evaluator] = {}
    for scene in practised:
        reconstructor = reconstructor_of(Capture.load(folders[scene]), reconstruction)
        for request, part in read_table(splits[scene]).groupby("request"):
            targets = Split.from_table(part).targets
            evaluator = Evaluator.on_frames(reconstructor, targets, metrics=METRIC)
            evaluators[scene, int(request)] = evaluator

    def judge(lesson: Lesson, rows: np.ndarray) -> float:
        return float(evaluators[lesson.place](lesson.pairs.prepared.pool[rows])[0])

    return judge


def _record(
    name: str, given: Sequence[Lesson], made: Sequence[Learned], seconds: float
) -> dict[str, object]:
    return {
        "method": name,
        "seeds": len(made),
        "lessons": len(given),
        "subsets": sum(len(lesson.subsets) for lesson in given),
        "parameters": parameters(made[0]),
        "seconds": seconds,
    }
