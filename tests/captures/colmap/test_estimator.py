"""Programs that find poses: what they are given, what is taken of what they leave, refusals."""

import sys

import numpy as np
import pose_program
import pytest

from fsel.captures.colmap.estimator import Estimator, checked
from fsel.captures.colmap.runs import Work
from fsel.captures.images import files as image_files
from fsel.captures.layouts import bare
from fsel.captures.poses import sfm
from fsel.captures.read import read_folder
from fsel.core.programs import MissingRequirement


@pytest.fixture
def photos(tmp_path):
    """Six photos in a folder, named otherwise than a program sees them."""
    names = [f"shot {row}.png" for row in range(6)]
    image_files.write(np.full((6, 48, 64, 3), 99, np.uint8), tmp_path / "photos", names)
    return tmp_path / "photos"


def test_the_largest_model_is_taken_under_the_photos_own_names(photos, tmp_path):
    by = Estimator(by=pose_program.written(tmp_path))
    found = sfm.reconstruct(bare.read(photos), work=Work(by=by))
    assert found.names == [f"shot {row}.png" for row in range(5)]
    assert found.dropped == {"shot 5.png": "not placed by places"}
    parabola = [[at, 0, at * at] for at in range(5)]
    np.testing.assert_allclose(found.world_to_camera[:, :, 3], parabola, atol=1e-12)
    assert found.sparse() is None
    assert Estimator(by=[["colmap", "mapper"], ["glomap", "mapper"]]).name == "glomap"


def test_a_capture_is_read_with_a_programs_poses(photos, tmp_path):
    read = read_folder(photos, "images", 32, poses={"by": pose_program.written(tmp_path)})
    assert len(read.capture) == 5


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


@pytest.mark.parametrize(
    ("given", "instead", "said"),
    [
        ("names[:2], names", "names[:1], names[:2]", "placed 2 of 6 frames"),
        ("1 {name}", "1 x{name}", r"placed 'x00000\d\.png', none of"),
    ],
)
def test_two_frames_are_too_few_and_other_images_are_refused(
    given, instead, said, photos, tmp_path
):
    text = pose_program.TEXT.replace(given, instead)
    by = Estimator(by=pose_program.written(tmp_path, text=text))
    with pytest.raises(ValueError, match=said):
        sfm.place(bare.read(photos), work=Work(by=by))


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
        ({"by": []}, ValueError, "by must be"),
        ({"by": "glomap mapper"}, ValueError, "by must be a list of strings, got 'glomap mapper'"),
        ({"by": ["true"], "model": "x"}, ValueError, "no setting 'model'; allowed: venv"),
    ],
)
def test_what_cannot_work_is_refused_before_work(poses, error, said):
    with pytest.raises(error) as refused:
        checked(poses)
    assert said in str(refused.value)
