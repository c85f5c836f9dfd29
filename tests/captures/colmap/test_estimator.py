"""Programs that find poses: what they are given, what is taken of what they leave, refusals."""

import sys

import numpy as np
import pytest
from small_captures import ring

from fsel.captures.colmap.estimator import Estimator, checked
from fsel.captures.colmap.runs import Work
from fsel.captures.layouts import bare
from fsel.captures.poses import sfm
from fsel.core.programs import MissingRequirement

# places all images but the last on a ring, in two models; arguments: folder, images of the second
PROGRAM = """
import sys
from pathlib import Path
import numpy as np, pycolmap
folder, few = Path(sys.argv[1]), int(sys.argv[2])
assert Path.cwd() == folder and not list((folder / "sparse").iterdir())
names = sorted(path.name for path in (folder / "images").iterdir())
poses = np.load(sys.argv[3])
for at, part in enumerate((names[:-1], names[:few])):
    model = pycolmap.Reconstruction()
    lens = dict(model="PINHOLE", width=32, height=24, params=[30, 30, 16, 12])
    camera = pycolmap.Camera(camera_id=1, **lens)
    model.add_camera_with_trivial_rig(camera)
    for row, name in enumerate(part):
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(poses[row, :, :3]), poses[row, :, 3])
        image = pycolmap.Image(image_id=row + 1, name=name, camera_id=1)
        model.add_image_with_trivial_frame(image, rigid)
    place = folder / "sparse" / str(1 - at)
    place.mkdir()
    model.write_text(str(place)) if at else model.write(str(place))
print("done")
"""


@pytest.fixture
def photos(tmp_path):
    """Six photos in a folder, named otherwise than a program sees them."""
    import cv2

    folder = tmp_path / "photos"
    folder.mkdir()
    for row in range(6):
        noise = np.random.default_rng(row).integers(0, 255, (24, 32, 3), np.uint8)
        cv2.imwrite(str(folder / f"shot {row}.png"), noise)
    return folder


@pytest.fixture
def program(tmp_path):
    """A command that places all photos but the last."""
    (tmp_path / "place.py").write_text(PROGRAM)
    np.save(tmp_path / "ring.npy", ring(6))
    return [sys.executable, str(tmp_path / "place.py"), "{folder}", "3", str(tmp_path / "ring.npy")]


def test_the_largest_model_is_taken_under_the_photos_own_names(photos, program):
    raw = bare.read(photos)
    found = sfm.reconstruct(raw, work=Work(by=Estimator(by=program)))
    assert found.names == [f"shot {row}.png" for row in range(5)]
    assert found.dropped == {"shot 5.png": "not placed by place"}
    np.testing.assert_allclose(found.world_to_camera, ring(6)[:5], atol=1e-12)
    assert found.sparse() is None
    assert Estimator(by=[["colmap", "mapper"], ["glomap", "mapper"]]).name == "glomap"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("print('no features'); exit(3)", r"poses by python.*: .*exit code 3\nno features"),
        ("print('nothing')", r"it wrote no COLMAP model .*\nnothing"),
        ("open('sparse/images.bin', 'w').write('no')", r"sparse"),
    ],
)
def test_a_program_that_fails_is_told_with_its_last_lines(photos, text, said):
    by = Estimator(by=[[sys.executable, "-c", "pass"], [sys.executable, "-c", text]])
    with pytest.raises(ValueError, match=said):
        sfm.reconstruct(bare.read(photos), work=Work(by=by))


def test_two_frames_are_too_few_and_other_images_are_refused(photos, program):
    text = PROGRAM.replace("names[:-1]", "names[:2]").replace("names[:few]", "names[:1]")
    two = Estimator(by=[sys.executable, "-c", text, *program[2:]])
    with pytest.raises(sfm.NotPlaced, match="placed 2 of 6 frames"):
        sfm.place(bare.read(photos), work=Work(by=two))
    text = PROGRAM.replace("name=name", "name='x' + name")
    others = Estimator(by=[sys.executable, "-c", text, *program[2:]])
    with pytest.raises(ValueError, match=r"placed 'x00000\d\.png', none of"):
        sfm.place(bare.read(photos), work=Work(by=others))


@pytest.mark.parametrize(
    ("poses", "error", "said"),
    [
        (
            {"by": ["no_such_program", "{folder}"]},
            MissingRequirement,
            "no program 'no_such_program'",
        ),
        ({"by": [["true"], ["./mine"]]}, MissingRequirement, "where it runs. Hint: {here}/./mine"),
        ({"by": ["true", "{model}"]}, ValueError, "{model} in '{model}'; allowed: {folder}"),
        ({"by": []}, ValueError, "by must be a command"),
        ({"by": "glomap mapper"}, ValueError, "by must be a list of strings, got 'glomap mapper'"),
        ({"by": ["true"], "model": "x"}, ValueError, "no setting 'model'; allowed: venv"),
    ],
)
def test_what_cannot_work_is_refused_before_work(poses, error, said):
    with pytest.raises(error) as refused:
        checked(poses)
    assert said in str(refused.value)
