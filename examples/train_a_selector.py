"""Train a selector: search subsets of training scenes, order them, imitate them, select.

python examples/train_a_selector.py                          # on generated scenes
python examples/train_a_selector.py captures/a captures/b    # on captures; the last one tests

It needs the extra `workflow` (for torch). The settings are small, so
that it runs in seconds; the workflow's are in config/config.yaml.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import fsel
from fsel.captures.images.previews import sharpness
from fsel.core.geometry import pairwise_distances, pose_distance
from fsel.core.problem import Problem, checked_select
from fsel.core.split import evaluation_split
from fsel.evaluation.evaluator import Evaluator
from fsel.features.appearance import descriptors
from fsel.selectors.policies import POLICIES
from fsel.selectors.rollout import Rollout, follow
from fsel.selectors.scorer import Network
from fsel.synthetic import record
from fsel.training.imitation import Trajectory, train
from fsel.training.ordering import order_subset, trajectory_weights
from fsel.training.search import GeneticSettings, genetic_search

K, TARGETS, KEPT = 6, 6, 2
SEARCH = GeneticSettings(population=8, farthest=3, uniform=2, generations=3)
POLICY = POLICIES["less_is_more"]  # what the scorer may see and pick: the paper's


def captures():
    """The given captures, or three generated ones."""
    if len(sys.argv) > 1:
        return [fsel.read_capture(folder, long_side=48) for folder in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as folder:
        made = []
        for seed in range(3):
            place = Path(folder, str(seed))
            fsel.LAYOUTS["dl3dv"].write(record("dl3dv", seed, 40, 64, 48), place)
            made.append(fsel.read_capture(place, long_side=48))
        return made


def posed(capture):
    """A problem: targets held out, a proxy for each, the rest candidates (paper, section 3.1)."""
    split = evaluation_split(capture, draw=0, seed=0, targets=TARGETS)
    images = np.asarray(capture.images)
    seen, sharp = descriptors(images, "lab_hog"), sharpness(images)
    views = capture.view(split.targets)
    return split, Problem(capture, split.candidates, split.proxies, views, seen, sharp)


def labelled(capture):
    """Search by reconstruction, then order the fittest subsets (sections 3.4 and 3.5)."""
    split, problem = posed(capture)
    evaluate = Evaluator.on_frames(fsel.RECONSTRUCTORS["splats"](capture), split.proxies)
    rng = np.random.default_rng(0)
    pool, centers, axes = split.candidates, capture.centers, capture.axes
    found = genetic_search(evaluate, pool, split.region, centers, K, rng, SEARCH)
    rows = found.best(KEPT)
    prepared = POLICY.prepare(problem)
    for row, weight in zip(rows, trajectory_weights(found.fitness[rows]), strict=True):
        subset = found.subsets[row]
        apart = pose_distance(centers[subset], axes[subset], centers[subset], axes[subset])
        to_proxies = pairwise_distances(centers[subset], centers[split.proxies])
        ordered = subset[order_subset(to_proxies, apart)]
        picks = np.searchsorted(prepared.pool, ordered)
        features, selectable = follow(Rollout(prepared), picks)
        yield Trajectory(features, selectable, picks, weight)


*training, unseen = captures()
trajectories = [trajectory for capture in training for trajectory in labelled(capture)]
print(f"{len(trajectories)} labels of {K} picks from {len(training)} scenes")

weights, log = train(trajectories, [], seed=0, epochs=5, learning_rate=1e-3)
print(f"loss {log['loss'][0]:.2f} -> {log['loss'][-1]:.2f} nats")
Network(weights, {"policy": POLICY.name, "made by": "an example"}).save("mine.safetensors")

method = POLICY.method(Network.load("mine.safetensors"))
split, problem = posed(unseen)
picks = checked_select(method, problem, K, np.random.default_rng(0))
score = Evaluator.on_frames(fsel.RECONSTRUCTORS["splats"](unseen), split.targets)
print(f"picked {', '.join(unseen.names[i] for i in picks)}: {score(picks)[0]:.2f} dB")
