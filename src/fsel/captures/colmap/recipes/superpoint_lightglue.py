"""SuperPoint (DeTone et al. 2018) and LightGlue (Lindenberger et al. 2023) by hloc, then COLMAP.

    python superpoint_lightglue.py FOLDER

Run where hloc (https://github.com/cvg/Hierarchical-Localization) is installed. Of more than 150
images each is matched with the 40 that look most alike by NetVLAD. SuperPoint's weights are for
non-commercial research.
"""

import sys
from pathlib import Path

from hloc import (
    extract_features,
    match_features,
    pairs_from_exhaustive,
    pairs_from_retrieval,
    reconstruction,
)

EXHAUSTIVE, ALIKE = 150, 40


def main(folder):
    """Write a model of the folder's images into `sparse`."""
    images, work = Path(folder, "images"), Path(folder, "hloc")
    work.mkdir(exist_ok=True)
    names, pairs = sorted(path.name for path in images.iterdir()), work / "pairs.txt"
    if len(names) > EXHAUSTIVE:
        alike = extract_features.main(extract_features.confs["netvlad"], images, work)
        pairs_from_retrieval.main(alike, pairs, num_matched=ALIKE)
    else:
        pairs_from_exhaustive.main(pairs, image_list=names)
    points = extract_features.confs["superpoint_max"]
    features = extract_features.main(points, images, work)
    matcher = match_features.confs["superpoint+lightglue"]
    matches = match_features.main(matcher, pairs, points["output"], work)
    model = reconstruction.main(work / "sfm", images, pairs, features, matches)
    if model is None:
        sys.exit("hloc built no model")
    model.write(str(Path(folder, "sparse")))


if __name__ == "__main__":
    main(*sys.argv[1:])
