"""MASt3R-SfM (Duisterhof et al. 2024) from a clone of https://github.com/naver/mast3r.

    python mast3r_sfm.py FOLDER REPOSITORY [WEIGHTS [GRAPH]]

Run in its environment. WEIGHTS is a file or name that `AsymmetricMASt3R.from_pretrained` takes;
GRAPH says which pairs are matched, as its `make_pairs` takes it: `complete`, or `swin-10` for
neighbours in a video. The model has cameras alone: `points: triangulate` makes points of them. Code
and weights are non-commercial (CC BY-NC-SA 4.0).
"""

import sys
from importlib import import_module
from pathlib import Path

WEIGHTS = "naver/MASt3R_ViTLarge_BaseDecoder_512_catmlpdpt_metric"
SIZE = 512  # of the long side that it works on


def main(folder, repository, weights=WEIGHTS, graph="complete"):
    """Write a model of the folder's images into `sparse`, as text."""
    sys.path.insert(0, repository)
    import torch
    from mast3r.cloud_opt.sparse_ga import sparse_global_alignment
    from mast3r.model import AsymmetricMASt3R

    import_module("mast3r.utils.path_to_dust3r")  # it puts dust3r on the path
    from dust3r.image_pairs import make_pairs
    from dust3r.utils.image import load_images

    device = "cuda" if torch.cuda.is_available() else "cpu"
    files = sorted(map(str, Path(folder, "images").iterdir()))
    loaded = load_images(files, size=SIZE)
    pairs = make_pairs(loaded, scene_graph=graph, prefilter=None, symmetrize=True)
    model = AsymmetricMASt3R.from_pretrained(weights).to(device)
    cache = str(Path(folder, "mast3r"))
    scene = sparse_global_alignment(files, pairs, cache, model, device=device)
    matrices = torch.stack(list(scene.intrinsics)).detach().cpu().numpy()
    poses = scene.get_im_poses().detach().cpu().numpy()
    shapes = [image["true_shape"][0] for image in loaded]
    write(Path(folder, "sparse"), files, shapes, matrices, poses)


def write(output, files, shapes, matrices, poses):
    """Write cameras as COLMAP's text: of the whole image, which was made smaller and cut.

    Args:
        files: paths of the N images.
        shapes: height and width of each as the network saw it.
        matrices: (N, 3, 3) intrinsics of that; pixels have their coordinates at their centres.
        poses: (N, 4, 4) camera to world.
    """
    import numpy as np
    from PIL import Image
    from scipy.spatial.transform import Rotation

    cameras, images = [], []
    for number, (file, shape, matrix, pose) in enumerate(
        zip(files, shapes, matrices, poses, strict=True), start=1
    ):
        with Image.open(file) as image:
            full = np.array(image.size)
        smaller = SIZE / full.max()
        cut = np.round(full * smaller) // 2 - np.array(shape)[::-1] // 2  # around the middle
        center = (matrix[:2, 2] + 0.5 + cut) / smaller
        inner = [matrix[0, 0] / smaller, matrix[1, 1] / smaller, *center]
        world = np.linalg.inv(pose)
        x, y, z, w = Rotation.from_matrix(world[:3, :3]).as_quat()
        cameras.append(" ".join(map(str, [number, "PINHOLE", *full, *inner])))
        place = [number, w, x, y, z, *world[:3, 3], number, Path(file).name]
        images.append(" ".join(map(str, place)) + "\n")  # a line of no observations
    (output / "cameras.txt").write_text("\n".join(cameras) + "\n")
    (output / "images.txt").write_text("\n".join(images) + "\n")
    (output / "points3D.txt").write_text("")


if __name__ == "__main__":
    main(*sys.argv[1:])
