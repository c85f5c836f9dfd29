"""GLOMAP's global mapping (Pan et al. 2024), through pycolmap 4 or later, on the CPU.

    python glomap.py FOLDER [SETTING=VALUE ...]

Settings are those of `pycolmap.GlobalPipelineOptions`. Images of one size have one camera. All
pairs are matched; of more than 150 images each with those 1 to 10, 16, 32, ... behind it by name.
The global mapper depends on focal lengths, which are guesses at first: it is run again with those
that it found.
"""

import json
import shutil
import sys
from pathlib import Path

import pycolmap

EXHAUSTIVE = 150


def main(folder, *given):
    """Write a model of the folder's images into `sparse`."""
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
    settings = {key: json.loads(value) for key, _, value in (word.partition("=") for word in given)}
    options = pycolmap.GlobalPipelineOptions({"random_seed": 0} | settings)
    model = mapped(database, images, Path(folder, "guessed"), options)
    with pycolmap.Database.open(str(database)) as stored:
        for camera in model.cameras.values():
            camera.has_prior_focal_length = True
            stored.update_camera(camera)
        stored.clear_two_view_geometries()
    pycolmap.geometric_verification(database)
    model = max(model, mapped(database, images, Path(folder, "found"), options), key=size)
    model.write(Path(folder, "sparse"))


def mapped(database, images, output, options):
    """The largest model that the global mapper builds."""
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir()
    models = pycolmap.global_mapping(database, images, output, options)
    if not models:
        sys.exit("GLOMAP built no model")
    return max(models.values(), key=size)


def size(model):
    """Images of a model, then their observations of its points."""
    return model.num_reg_images(), model.compute_num_observations()


if __name__ == "__main__":
    main(*sys.argv[1:])
