"""Hard images, searches and trainings, and scenes to reconstruct."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from fsel.captures.images.previews import sharpness
from fsel.core.capture import Capture
from fsel.core.geometry import pixel_rays
from fsel.core.points import SparsePoints
from fsel.experiments.studies.hard_cases import Case, CaseOutcome, finite, quality, worlds
from fsel.features.appearance import descriptors
from fsel.features.columns import INPUTS
from fsel.metrics import PSNR_CEILING, score_views
from fsel.reconstruct.splats import Splats
from fsel.selectors.scorer import WIDTH
from fsel.training.ordering import order_subset, trajectory_weights
from fsel.training.search import (
    GeneticSettings,
    fitness,
    genetic_search,
    random_search,
    swap_search,
)

SHAPE = (3, 24, 32, 3)
C1 = 0.01**2  # of SSIM, for images in 0..1
EXPECTED = "sharpness 0; a unit descriptor, none for black; SSIM 1 and GMSD 0 with itself"
K = 6
DEPTH = 4.0
SHARE = 20  # one point in so many lies at the odd depth
# of the wall's depth: the gap between two depth planes there. The last bits of the matching costs
# decide between neighbouring planes, and they differ between processors: the median error is
# 0.017 where vectors hold eight float32, 0.022 where they hold sixteen
PLANE = 0.027


def blank(level: int) -> CaseOutcome:
    """A uniform image has no sharpness, a descriptor of length one (black: none), and is itself."""
    images = np.full(SHAPE, level, np.uint8)
    sharp, described = sharpness(images), descriptors(images, "lab_hog")
    scores = score_views((images / np.float32(255)).astype(np.float32), images)
    finite(sharp, described, scores)
    length = np.linalg.norm(described.astype(np.float64), axis=1)
    off = (sharp, length - (level > 0), scores[:, 1] - 1, scores[:, 2])
    error = max(np.abs(values).max() for values in off)
    observed = f"sharpness {sharp[0]:.2g}; descriptor {length[0]:.6f}; PSNR {scores[0, 0]:.1f} dB"
    return CaseOutcome(observed, float(error) if scores[0, 0] >= PSNR_CEILING else np.inf, 1e-6)


def black_against_white() -> CaseOutcome:
    """PSNR 0 dB and SSIM C1 / (1 + C1): means differ by one and nothing varies."""
    scores = score_views(np.zeros(SHAPE, np.float32), np.full(SHAPE, 255, np.uint8))
    finite(scores)
    error = max(np.abs(scores[:, 0]).max(), np.abs(scores[:, 1] - C1 / (1 + C1)).max())
    return CaseOutcome(f"PSNR {scores[0, 0]:.3g} dB; SSIM {scores[0, 1]:.6f}", float(error), 1e-9)


def equal_fitness() -> CaseOutcome:
    """Retained subsets of one fitness weigh the same, whatever the fitness is."""
    error = 0.0
    for level in (0.0, 1.0, 1 / 3, 1e-300):
        weights = trajectory_weights(np.full(4, level))
        finite(weights)
        error = max(error, float(np.abs(weights - 1).max()))
    return CaseOutcome("all weights 1" if error == 0 else "weights differ", error, 0.0)


def one_fitter_subset() -> CaseOutcome:
    """Fitnesses apart by one unit in the last place are as good as equal; weights keep mean one."""
    weights = trajectory_weights(np.array([0.5, 0.5, 0.5, np.nextafter(0.5, 1)]))
    finite(weights)
    return CaseOutcome(f"weights {np.round(weights, 4).tolist()}", float(np.ptp(weights)), 1e-3)


def equal_metrics() -> CaseOutcome:
    """Searches that cannot tell subsets apart still return distinct ones of the right size."""
    problem, rng = worlds.world(), np.random.default_rng(0)
    pool, centers = problem.candidates, problem.capture.centers

    def flat(subset: np.ndarray) -> np.ndarray:
        return np.array([20.0, 0.5, 0.1])

    small = GeneticSettings(population=8, farthest=3, uniform=2, generations=3)
    results = [
        genetic_search(flat, pool, pool, centers, K, rng, small),
        random_search(flat, pool, K, 20, rng),
        swap_search(flat, pool, [pool[:K]], 20, rng),
    ]
    error, sizes = 0.0, []
    for result in results:
        finite(result.fitness)
        error = max(error, float(np.abs(result.fitness).max()))
        distinct = {tuple(np.unique(subset)) for subset in result.subsets}
        sizes.append(len(distinct))
        if len(distinct) < len(result.subsets) or any(len(s) < K for s in distinct):
            error = np.inf
    return CaseOutcome(f"fitness 0; {sizes} distinct subsets", error, 0.0)


def far_metric() -> CaseOutcome:
    """A PSNR of 1e12 among ordinary ones leaves fitness in 0..1, and right to rounding."""
    metrics = np.array([[20.0, 0.5, 0.1], [21.0, 0.6, 0.1], [1e12, 0.55, 0.1]])
    got = fitness(metrics)
    finite(got)
    exact = np.array([0.0, (1 / (1e12 - 20) + 1) / 3, (1 + 0.5) / 3])
    error = float(np.abs(got - exact).max())
    return CaseOutcome(f"fitness {np.round(got, 6).tolist()}", error, 1e-12)


def equal_distances() -> CaseOutcome:
    """Frames in one place that serve all views alike are taken in their own order."""
    apart = np.zeros((K, K))
    orders = [order_subset(np.full((K, 3), value), apart) for value in (0.0, 1e-300, 1e12)]
    error = max(float(np.abs(order - np.arange(K)).max()) for order in orders)
    return CaseOutcome("lowest rows first" if error == 0 else str(orders), error, 0.0)


def loud_training() -> CaseOutcome:
    """Inputs that make logits of 10^4: float32 losses against float64 ones."""
    import torch  # only training needs it

    from fsel.training.imitation import Trajectory, imitation, perceptron, train

    rng = np.random.default_rng(0)
    items = []
    for _ in range(3):
        features = rng.normal(scale=2e5, size=(K, 20, INPUTS)).astype(np.float32)
        picks = rng.permutation(20)[:K]
        selectable = np.ones((K, 20), bool)
        for step in range(K):
            selectable[step, picks[:step]] = False
        items.append(Trajectory(features, selectable, picks, 1.0))
    weights, log = train(items, [], seed=0, epochs=2, learning_rate=1e-3)
    finite(*weights.values(), log["loss"])
    torch.manual_seed(0)
    network, losses = perceptron(WIDTH).double(), []
    for item in items:
        scores = network(torch.from_numpy(item.features).double()).squeeze(-1)
        labels = torch.from_numpy(item.selectable), torch.from_numpy(item.picks)
        losses.append(imitation(scores, *labels)[0].item())
    exact, (first, *_, last) = np.mean(losses), log["loss"]
    error = float(np.abs(first / exact - 1))
    return CaseOutcome(f"loss {exact:.4g}, after two epochs {last:.4g}", error, 1e-5)


def wall(depth: float, odd: float | None = None) -> Capture:
    """Twelve cameras abreast before a painted plane, with points on it and, optionally elsewhere.

    Args:
        depth: of the plane, world units; baselines and paint are in proportion.
    """
    n, count = 12, 200
    place = np.zeros((n, 3))
    place[:, 0] = (np.arange(n) - n / 2) * 0.25 * depth / DEPTH
    camera = np.array([40.0, 40.0, 24.0, 18.0])
    seen = pixel_rays(camera, 48, 36) + place[:, None, None] / depth
    rng = np.random.default_rng(0)
    xyz = np.column_stack([rng.uniform(-1, 1, (count, 2)) * depth / 3, np.full(count, depth)])
    if odd is not None:
        xyz[::SHARE] *= odd / depth
    tracks = np.tile(np.arange(count), n), np.repeat(np.arange(n), count)
    return Capture(
        names=tuple(f"{i:02d}" for i in range(n)),
        world_to_camera=worlds.poses(place, np.tile([0.0, 0.0, 1.0], (n, 1))),
        intrinsics=np.tile(camera, (n, 1)),
        images=worlds.paint(seen),
        sequences=("a",) * n,
        points=SparsePoints(xyz, np.zeros((count, 3), np.uint8), *tracks),
    )


def measure_quality(capture: Capture) -> tuple[float, float]:
    """Measure PSNR in dB of every fourth frame from the others, and the median depth error."""
    held = np.arange(1, len(capture), 4)
    frames = np.setdiff1d(np.arange(len(capture)), held)
    position = Splats(capture).fit(frames).positions
    finite(position)
    assert capture.points is not None  # `wall` gives them
    depth = np.median(capture.points.xyz[:, 2])
    return quality(capture, frames, held), float(np.median(np.abs(position[:, 2] / depth - 1)))


def of_depth(depth: float, odd: float | None, allowed: float) -> CaseOutcome:
    """Depth error of the wall; PSNR against the same wall with all points on it."""
    usual, _ = measure_quality(wall(DEPTH))
    psnr, error = measure_quality(wall(depth, odd))
    return CaseOutcome(f"PSNR {psnr:.2f} dB, plain wall {usual:.2f}", error, allowed)


def turned_about() -> CaseOutcome:
    """Two walls back to back: no frame of one half sees anything of the other's."""
    first = wall(DEPTH)
    back = np.diag([-1.0, 1.0, -1.0])
    second = first.world_to_camera.copy()
    second[:, :, :3] = second[:, :, :3] @ back
    both = replace(
        first,
        names=(*first.names, *(f"b{name}" for name in first.names)),
        world_to_camera=np.concatenate([first.world_to_camera, second]),
        intrinsics=np.tile(first.intrinsics, (2, 1)),
        images=np.tile(first.images, (2, 1, 1, 1)),
        sequences=first.sequences * 2,
        points=None,
    )
    half = np.array([2, 3, 4, 6, 7])
    several = (half, np.append(half, half + 12))
    alone, together = (quality(both, frames, np.array([5])) for frames in several)
    observed = f"PSNR {alone:.2f} dB, with the other side's frames {together:.2f}"
    return CaseOutcome(observed, float(abs(together - alone)), 0.01)


CASES = (
    *(
        Case(f"{name} images", EXPECTED, partial(blank, level))
        for name, level in (("black", 0), ("uniform grey", 119), ("white", 255))
    ),
    Case("black against white", "PSNR 0 dB; SSIM C1 / (1 + C1)", black_against_white),
    Case("equal fitness of all retained subsets", "equal weights", equal_fitness),
    Case("fitness apart by one last bit", "equal weights to rounding", one_fitter_subset),
    Case("equal metrics of all evaluated subsets", "fitness 0, searches end", equal_metrics),
    Case("a metric with one outlier of 1e12", "fitness by hand", far_metric),
    Case("equal distances of a subset to all views", "order of the frames", equal_distances),
    Case("logits of 1e4, training", "the float64 loss", loud_training),
    Case("a scene with one depth", "that depth", lambda: of_depth(DEPTH, None, PLANE)),
    Case("a scene at depth 1e-4", "that depth", lambda: of_depth(1e-4, None, PLANE)),
    Case("a scene at depth 1e6", "that depth", lambda: of_depth(1e6, None, PLANE)),
    Case("a near plane of 1e-4", "the wall's depth", lambda: of_depth(DEPTH, 1e-4, 0.1)),
    Case("a far plane at 1e6", "the wall's depth", lambda: of_depth(DEPTH, 1e6, 0.1)),
    Case("two halves of a scene back to back", "neither harms the other", turned_about),
)
