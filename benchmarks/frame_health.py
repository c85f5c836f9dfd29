"""What frame health finds, and what it calls bad that is good.

    OMP_NUM_THREADS=1 python benchmarks/frame_health.py films -o results/tables/frame_health.csv
    ... frame_health.py captures FOLDER... -o results/tables/frame_health_captures.csv
    ... frame_health.py gain --scenes 4 5 6 7

`films`: generated films of 480x360 pixels without any effect of a sensor. A fifth of the frames is
spoilt, each by one motion blur of known length in a direction at random, in linear light, under a
gain, a gamma, noise or a window that burns out; those under the same effect without blur are sharp.
What is found of each kind, at the threshold that gives 1 % false alarms on sharp frames of the same
effect and as shipped; beside it, the variance of the Laplacian over that of frames beside, which
was the rule before. `captures`: captures from disk, as they are, with three poses turned by 10
degrees and shifted, with eight frames 1.6 times as bright, with a stretch of 15 frames blurred by 9
to 18 pixels, with a pause of 12 frames, and with a hand before four frames: what is found, and what
else. `gain`: PSNR of `gaussians` on sharp held-out frames of generated videos with strong blur, of
picks with bad frames left out over picks with them.
"""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
import pandas as pd
from gaussians import fitted, scores
from sensor_effects import filmed

import fsel
from fsel.captures.images import files as image_files
from fsel.captures.images.previews import sharpness_of_files
from fsel.captures.images.sharpness import variance_of_laplacian
from fsel.captures.layouts import LAYOUTS
from fsel.captures.lazy import LazyCapture, open_capture
from fsel.captures.quality import findings, photometry
from fsel.captures.quality.cells import Cells, measured, sharpness
from fsel.captures.quality.examination import examined
from fsel.core.capture import Capture
from fsel.core.geometry import pose_distance
from fsel.evaluation.numbers import write_csv
from fsel.evaluation.statistics import of_places
from fsel.synthetic import record

FAMILIES = ("mipnerf360", "tanks_and_temples", "seven_scenes")  # filmed without distortion
SEED = 100  # of scenes that nothing else is made of
EVERY = 5  # one frame in so many is spoilt at once
LENGTHS = (0, 2, 4, 8, 16)  # pixels of motion
EFFECTS: dict[str, dict[str, float]] = {
    "none": {},
    "gain 1.6": {"gain": 1.6},
    "gain 0.6": {"gain": 0.6},
    "gamma 1.4": {"gamma": 1.4},
    "gamma 0.7": {"gamma": 0.7},
    "noise 3": {"noise": 3},
    "noise 6": {"noise": 6},
    "burnt window": {"window": 6},
}
ALARMS = 1.0  # per cent
MEASURES = ("health", "laplacian")
TURN, SHIFT, BRIGHTER = np.radians(10), 0.05, 1.6
SKIN = (205, 150, 120)  # of a hand before the camera
KINDS = (
    findings.BLURRED,
    findings.MISPLACED,
    findings.EXPOSED,
    findings.TINTED,
    findings.BURNT,
    findings.COVERED,
    findings.DUPLICATE,
)
ALSO = {  # kinds by which a spoilt frame may be found, where there are several
    findings.EXPOSED: (findings.EXPOSED, findings.BURNT, findings.TINTED)
}
WIDTH, STEPS, GAUSSIANS = 320, 600, 15_000


def line(pixels: float, angle: float) -> np.ndarray:
    """A kernel of constant motion, its ends between pixels."""
    size = 2 * int(np.ceil(pixels / 2)) + 3
    kernel = np.zeros((size, size))
    for t in np.linspace(-pixels / 2, pixels / 2, 201):
        x, y = size // 2 + t * np.cos(angle), size // 2 + t * np.sin(angle)
        column, row = int(x), int(y)
        for down, high in ((0, 1 - y + row), (1, y - row)):
            for right, wide in ((0, 1 - x + column), (1, x - column)):
                kernel[row + down, column + right] += high * wide
    return kernel / kernel.sum()


def spoilt(
    image: np.ndarray,
    rng: np.random.Generator,
    pixels: float,
    gain: float = 1,
    gamma: float = 1,
    noise: float = 0,
    window: float = 1,
) -> np.ndarray:
    """An image as a moving camera of another exposure sees it; `gain` is of the stored values."""
    light = (image / 255.0) ** 2.2
    if window > 1:
        height, width = image.shape[:2]
        x, y = rng.uniform(0.2, 0.8) * width, rng.uniform(0.2, 0.8) * height
        distance = np.hypot(*np.meshgrid(np.arange(width) - x, np.arange(height) - y))
        light *= (1 + (window - 1) * np.exp(-((distance / (0.3 * width)) ** 4)))[..., None]
    if pixels:
        light = cv2.filter2D(light, -1, line(pixels, rng.uniform(0, np.pi)))
    value = np.clip(light * gain**2.2, 0, 1) ** (gamma / 2.2) * 255
    return np.clip(np.rint(value + rng.normal(0, noise, value.shape)), 0, 255).astype(np.uint8)


class Film:
    """A film's cells, and where its points are seen in them."""

    def __init__(self, capture: Capture) -> None:
        points = capture.points
        self.images = np.asarray(capture.images)
        self.parts = [measured(np.ascontiguousarray(image)) for image in self.images]
        self.laplacian = np.array([laplacian(image) for image in self.images])
        distance = pose_distance(capture.centers, capture.axes, capture.centers, capture.axes)
        np.fill_diagonal(distance, np.inf)
        self.near = np.argsort(distance, axis=1, kind="stable")[:, :4]
        poses = capture.world_to_camera[points.track_frame]
        local = np.einsum("lij,lj->li", poses[..., :3], points.xyz[points.track_point])
        local += poses[..., 3]
        focal, middle = np.split(capture.intrinsics[points.track_frame], 2, axis=1)
        self.pixels = local[:, :2] / local[:, 2:] * focal + middle
        self.points = points

    def judged(self, rows: np.ndarray, images: list[np.ndarray]) -> np.ndarray:
        """(n, 2) of some frames in another form: over their thresholds by all three references, and
        how much less the variance of the Laplacian is than beside."""
        parts, old = list(self.parts), self.laplacian.copy()
        for row, image in zip(rows, images, strict=True):
            parts[row], old[row] = measured(image), laplacian(image)
        cells, points = Cells.of(parts), self.points
        cell = cells.at(self.pixels, np.ones(len(self.pixels)))
        detail = sharpness(cells)
        ratios = [
            photometry.blur_beside(detail, self.near) / photometry.BESIDE,
            photometry.blur_in_capture(detail) / photometry.OF_CAPTURE,
            photometry.blur_at_points(cells, cell, points.track_point, points.track_frame)
            / photometry.AT_POINTS,
        ]
        beside = old[self.near].max(axis=1) / np.maximum(old, 1e-9) / 2.5
        return np.stack([np.fmax.reduce(ratios), beside], axis=1)[rows]


def laplacian(image: np.ndarray) -> float:
    """The measure of before, of a grey image."""
    return variance_of_laplacian(cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2GRAY))


def films(asked: argparse.Namespace) -> None:
    """Write what is found of each kind, by both measures."""
    judged: dict[tuple[str, int], list[np.ndarray]] = {}
    for family in FAMILIES:
        without = ("noise", "drift", "vignette", "blur")
        film, rng = Film(filmed(family, SEED, without, width=480)), np.random.default_rng(SEED)
        rows = np.arange(2, len(film.images), EVERY)
        for effect, settings in EFFECTS.items():
            for pixels in LENGTHS:
                images = [spoilt(film.images[row], rng, pixels, **settings) for row in rows]
                judged.setdefault((effect, pixels), []).append(film.judged(rows, images))
        others = np.setdiff1d(np.arange(len(film.images)), rows)
        judged["none", 0].append(film.judged(others, [film.images[i] for i in others]))
        print(family, flush=True)
    together = {kind: np.concatenate(parts) for kind, parts in judged.items()}
    table = []
    for (effect, pixels), both in together.items():
        for name, values, sharp in zip(MEASURES, both.T, together[effect, 0].T, strict=True):
            row = {"effect": effect, "pixels": pixels, "measure": name, "frames": len(values)}
            alarm = np.nanpercentile(sharp, 100 - ALARMS)
            row["found_at_1_percent"] = float((values > alarm).mean())
            row |= {"found": float((values > 1).mean()), "area": area(sharp, values)}
            table.append(row)
    write_csv(pd.DataFrame(table), asked.out)


def area(sharp: np.ndarray, values: np.ndarray) -> float:
    """Area under the curve of found over false alarms: the share of pairs in the right order."""
    return float((values[:, None] > sharp).mean() + (values[:, None] == sharp).mean() / 2)


def turned(opened: LazyCapture, rng: np.random.Generator, rows: np.ndarray) -> LazyCapture:
    """Some poses turned by 10 degrees and shifted by a twentieth of the capture's extent."""
    poses = opened.raw.world_to_camera.copy()
    extent = np.ptp(opened.capture.centers, axis=0).max()
    for row in rows:
        axis, shift = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        poses[row] = cv2.Rodrigues(TURN * axis)[0] @ poses[row]
        poses[row, :, 3] += SHIFT * extent * shift
    raw = replace(opened.raw, world_to_camera=poses)
    return replace(opened, raw=raw, capture=replace(opened.capture, world_to_camera=poses))


def with_images(
    opened: LazyCapture, rows: np.ndarray, change: Callable[[int], np.ndarray], folder: Path
) -> LazyCapture:
    """The capture with some images changed: number of a frame -> (h, w, 3)."""
    images = list(opened.raw.images)
    for row in rows.tolist():
        images[row] = folder / f"{row:05d}.png"
        image_files.write(change(row)[None], folder, [images[row].name])
    return replace(opened, raw=replace(opened.raw, images=images))


def trials(opened: LazyCapture, folder: Path) -> Iterator[tuple[str, np.ndarray, LazyCapture]]:
    """The kind that is to be found, in which frames, and the capture."""
    rng, count = np.random.default_rng(SEED), len(opened.capture)
    load = [image_files.load(file) for file in opened.raw.images].__getitem__
    three, eight = (np.linspace(2, count - 3, n).astype(int) for n in (3, 8))
    start = count // 3
    yield findings.MISPLACED, three, turned(opened, rng, three)

    def bright(row: int) -> np.ndarray:
        return spoilt(load(row), rng, 0, gain=BRIGHTER)

    yield findings.EXPOSED, eight, with_images(opened, eight, bright, folder)
    stretch = np.arange(start, start + min(15, count // 4))

    def moved(row: int) -> np.ndarray:
        return spoilt(load(row), rng, rng.uniform(9, 18))

    yield findings.BLURRED, stretch, with_images(opened, stretch, moved, folder)
    pause = np.arange(start, start + min(12, count // 4))

    def still(_: int) -> np.ndarray:
        return spoilt(load(start - 1), rng, 0, noise=3)

    yield findings.DUPLICATE, pause, with_images(opened, pause, still, folder)
    four = np.linspace(6, count - 7, 4).astype(int)
    yield findings.COVERED, four, with_covers(opened, four, load, folder)


def with_covers(
    opened: LazyCapture, rows: np.ndarray, load: Callable[[int], np.ndarray], folder: Path
) -> LazyCapture:
    """The capture with a hand before the middle of some frames, where these see no points then."""
    rng, points = np.random.default_rng(SEED), opened.raw.sparse()

    def place(width: int, height: int) -> tuple:
        return (width // 2, height // 2), (int(0.4 * width), int(0.35 * height)), 20, 0, 360

    def covered(row: int) -> np.ndarray:
        image = load(row).copy()
        cv2.ellipse(image, *place(*image.shape[1::-1]), SKIN, -1)
        texture = cv2.GaussianBlur(rng.normal(0, 20, image.shape), (0, 0), 2)
        return np.clip(image + texture, 0, 255).astype(np.uint8)

    seen = np.ones(len(points.track_frame), bool)
    for row in rows:
        camera, here = opened.raw.cameras[row], np.flatnonzero(points.track_frame == row)
        mask = np.zeros((camera.height, camera.width), np.uint8)
        cv2.ellipse(mask, *place(camera.width, camera.height), 1, -1)
        x, y = points.track_xy[here].astype(int).T
        seen[here] = mask[y.clip(0, camera.height - 1), x.clip(0, camera.width - 1)] == 0
    tracks = ("track_point", "track_frame", "track_xy")
    left = replace(points, **{name: getattr(points, name)[seen] for name in tracks})
    changed = with_images(opened, rows, covered, folder)
    return replace(changed, raw=replace(changed.raw, points=lambda _: left))


def captures(asked: argparse.Namespace) -> None:
    """Write what is found on captures from disk, as they are and spoilt."""
    table = []
    for place in asked.folders:
        opened = open_capture(place, "colmap")
        plain = examined(opened)
        known = {(finding.frame, finding.kind) for finding in plain.findings}
        for kind in KINDS:
            frames = len(plain.of_kind(kind))
            table.append(row_of(place, "as it is", kind, 0, 0, frames, opened))
        with TemporaryDirectory() as folder:
            for kind, rows, changed in trials(opened, Path(folder)):
                findings_now = {(f.frame, f.kind) for f in examined(changed).findings}
                right = {(row, name) for row in rows.tolist() for name in ALSO.get(kind, (kind,))}
                hit = len({row for row, _ in findings_now & right})
                more = len({row for row, _ in findings_now - known - right})
                table.append(row_of(place, "spoilt", kind, len(rows), hit, more, opened))
        print(pd.DataFrame(table).query("capture == @place.name").to_string(), flush=True)
    write_csv(pd.DataFrame(table), asked.out)


def row_of(
    place: Path, how: str, kind: str, bad: int, found: int, others: int, opened: LazyCapture
) -> dict:
    """A row of the table of captures."""
    row = {"capture": place.name, "how": how, "kind": kind, "frames": len(opened.capture)}
    return row | {"spoilt": bad, "found": found, "others": others}


def gain(asked: argparse.Namespace) -> None:
    """Print PSNR and SSIM of picks without bad frames over picks with them."""
    rows = []
    for seed in asked.scenes:
        with TemporaryDirectory() as folder:
            place = Path(folder) / "capture"
            place.mkdir()
            made = record("scannet_iphone", seed, width=WIDTH, height=WIDTH * 3 // 4)
            LAYOUTS["colmap"].write(made, place)
            opened = open_capture(place, "colmap", WIDTH)
            health = examined(opened)
            capture = opened.loaded(np.arange(len(opened.capture)))
            sharp = sharpness_of_files(opened.raw.images, opened.longest)
            shutil.rmtree(place)
        usual = np.array([np.median(sharp[max(0, i - 5) : i + 6]) for i in range(len(sharp))])
        for start in asked.starts:
            held = np.arange(start, len(capture), 8)
            judges = held[sharp[held] >= 0.9 * usual[held]]
            for k in asked.k:
                result = []
                for bad in (np.empty(0, int), health.left_out):
                    rest = np.setdiff1d(np.arange(len(capture)), np.union1d(held, bad))
                    picks = rest[fsel.select(capture.subset(rest), k, patience=0).indices]
                    model, _ = fitted(capture, picks, steps=STEPS, gaussians=GAUSSIANS)
                    result.append(scores(model, capture, judges)[:2])
                    left = len(np.intersect1d(picks, health.left_out))
                    print(seed, start, k, left, result[-1].round(3), flush=True)
                rows.append({"scene": seed, "k": k, "gain": result[1] - result[0]})
    for k in asked.k:
        gains = np.array([row["gain"] for row in rows if row["k"] == k])
        for name, values in zip(("PSNR", "SSIM"), gains.T, strict=True):
            reach = of_places(values)
            print(f"k {k}, {name}: {reach.mean:+.3f} ({reach.low:+.3f} to {reach.high:+.3f})")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    commands = parser.add_subparsers(required=True)
    for name, function in (("films", films), ("captures", captures), ("gain", gain)):
        command = commands.add_parser(name)
        command.set_defaults(function=function)
        if function is not gain:
            command.add_argument("-o", "--out", type=Path, required=True)
        if function is captures:
            command.add_argument("folders", nargs="+", type=Path)
        if function is gain:
            command.add_argument("--scenes", nargs="+", type=int, default=[4, 5, 6, 7])
            command.add_argument("--starts", nargs="+", type=int, default=[1, 5])
            command.add_argument("--k", nargs="+", type=int, default=[20])
    asked = parser.parse_args()
    asked.function(asked)


if __name__ == "__main__":
    main()
