"""What one evaluation costs, averaged over a whole search with its caches filled on the way.

    python benchmarks/evaluation.py [--repeats 3]

Prints medians over the repeats of seconds of the processor, one line a stage, on one thread: K = 20
frames, 15 proxies, 64x48.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from fsel.core.capture import Capture, SparsePoints
from fsel.core.split import evaluation_split
from fsel.metrics import score_views
from fsel.reconstruct.splats import Splats, stereo
from fsel.synthetic import record
from fsel.training.search import genetic_search


def capture(seed: int) -> Capture:
    """A pinhole recording of 160 frames at 64x48, as ingestion would hand it on."""
    made = record("mipnerf360", seed, width=64, height=48)
    return Capture(
        made.names,
        made.world_to_camera,
        np.tile(made.camera.params, (len(made.names), 1)),
        made.images,
        made.sequences,
        SparsePoints(made.xyz, made.rgb, made.track_point, made.track_frame),
    )


def search(bound: Splats, split, seed: int) -> dict[str, float]:
    """Milliseconds an evaluation of one genetic search, by stage."""
    spent = {"fit": 0.0, "render": 0.0, "score": 0.0}
    views = bound.capture.view(split.proxies)
    truth = np.asarray(bound.capture.images[split.proxies])

    def evaluate(subset: np.ndarray) -> np.ndarray:
        marks = [time.process_time()]
        model = bound.fit(subset)
        marks.append(time.process_time())
        images = model.render(views)
        marks.append(time.process_time())
        metrics = score_views(images, truth).mean(axis=0)
        marks.append(time.process_time())
        for stage, seconds in zip(spent, np.diff(marks), strict=True):
            spent[stage] += seconds
        return metrics

    pool = split.candidates
    rng = np.random.default_rng(seed)
    result = genetic_search(evaluate, pool, split.region, bound.capture.centers, 20, rng)
    count = len(result.subsets)
    return {stage: 1e3 * seconds / count for stage, seconds in spent.items()} | {"subsets": count}


def kernels(bound: Splats) -> dict[str, float]:
    """Milliseconds of one pair's costs and of one depth map from four pairs."""
    order = bound._nearest(np.arange(len(bound.capture)))
    started = time.process_time()
    for i in range(20):
        bound._pair(i, int(order[i, 0]), keep=True)
    pair = time.process_time() - started
    costs = [bound._pair(0, int(j), keep=True) for j in order[0, :4]]
    started = time.process_time()
    for _ in range(20):
        cost = stereo.merge_costs(*costs, 4)
        total = stereo.aggregate(cost, bound.frames[0].grey, np.int16(48), np.float32(510))
        stereo.winner(total, cost, bound.inverse[0])
    return {"pair": 50 * pair, "depth map": 50 * (time.process_time() - started)}


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    repeats = parser.parse_args().repeats
    made = capture(0)
    split = evaluation_split(made, 0, 0)
    search(Splats(made), split, 0)  # compiles
    rows = []
    for repeat in range(repeats):
        bound = Splats(made)
        row = search(bound, split, repeat)
        again = search(bound, split, 100 + repeat)
        row["total, first search"] = sum(row[s] for s in ("fit", "render", "score"))
        row["total, second search"] = sum(again[s] for s in ("fit", "render", "score"))
        rows.append(row | kernels(Splats(made)))
    for name in rows[0]:
        value = np.median([row[name] for row in rows])
        unit = "" if name == "subsets" else " ms"
        print(f"{name:22s}{value:9.2f}{unit}")


if __name__ == "__main__":
    main()
