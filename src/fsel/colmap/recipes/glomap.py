"""GLOMAP's global mapping (Pan et al. 2024), through pycolmap 4 or later, on the CPU.

    python glomap.py FOLDER [SETTING=VALUE ...]

Settings are those of `pycolmap.GlobalPipelineOptions`. Images of one size have one camera. All
pairs are matched; of more than 150 images each with those 1 to 10, 16, 32, ... behind it by name.
"""

import json
import sys
from pathlib import Path

import pycolmap

EXHAUSTIVE = 150


def main(folder, *given):
    """Write models of the folder's images into `sparse`."""
    images, database = Path(folder, "images"), Path(folder, "database.db")
    cpu, sizes = pycolmap.Device.cpu, {}
    for path in sorted(images.iterdir()):
        bitmap = pycolmap.Bitmap.read(path, as_rgb=False)
        if bitmap is not None:
            sizes.setdefault((bitmap.width, bitmap.height), []).append(path.name)
    mode = pycolmap.CameraMode.SINGLE
    for names in sizes.values():
        pycolmap.extract_features(database, images, names, camera_mode=mode, device=cpu)
    number = sum(map(len, sizes.values()))
    match = pycolmap.match_sequential if number > EXHAUSTIVE else pycolmap.match_exhaustive
    match(database, device=cpu)
    pycolmap.calibrate_view_graph(database)
    settings = {key: json.loads(value) for key, _, value in (word.partition("=") for word in given)}
    options = pycolmap.GlobalPipelineOptions({"random_seed": 0} | settings)
    pycolmap.global_mapping(database, images, Path(folder, "sparse"), options)


if __name__ == "__main__":
    main(*sys.argv[1:])
