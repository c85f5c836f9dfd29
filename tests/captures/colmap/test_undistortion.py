"""Pixels move once, and as pycolmap and OpenCV move them."""

import cv2
import numpy as np
import pycolmap
import pytest

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.undistortion import Lens, common_frame, straight, undistortion_maps

CAMERAS = {
    "SIMPLE_RADIAL": (150.0, 80.4, 59.7, -0.08),
    "RADIAL": (150.0, 80.4, 59.7, -0.08, 0.02),
    "OPENCV": (150.0, 151.0, 80.4, 59.7, -0.08, 0.02, 1e-3, -2e-3),
    "FULL_OPENCV": (150.0, 151.0, 80.4, 59.7, -0.08, 0.02, 1e-3, -2e-3, 0.01, 0.0, 0.0, 0.0),
    "OPENCV_FISHEYE": (90.0, 90.0, 80.4, 59.7, -0.03, 0.006, -0.002, 2e-4),
}


def picture(seed=0):
    small = np.random.default_rng(seed).integers(0, 255, (12, 16, 3), dtype=np.uint8)
    return cv2.resize(small, (160, 120), interpolation=cv2.INTER_CUBIC)


def kept_size(camera):
    """COLMAP's own undistortion at the original size: image, and camera as ours."""
    options = pycolmap.UndistortCameraOptions()
    options.min_scale = options.max_scale = 1.0
    bitmap = pycolmap.Bitmap.from_array(picture())
    image, new = pycolmap.undistort_image(options, bitmap, camera.colmap)
    k = new.calibration_matrix()
    params = (k[0, 0], k[1, 1], k[0, 2], k[1, 2])
    return image.to_array(), Camera("PINHOLE", new.width, new.height, params)


@pytest.mark.parametrize("model", CAMERAS)
def test_undistortion_is_that_of_pycolmap(model):
    camera = Camera(model, 160, 120, CAMERAS[model])
    theirs, pinhole = kept_size(camera)
    maps = undistortion_maps(camera, pinhole, (160, 120))
    ours = cv2.remap(picture(), *maps, cv2.INTER_LINEAR)
    inner = np.abs(ours.astype(int) - theirs)[4:-4, 4:-4]
    assert np.median(inner) == 0
    assert inner.max() <= 4  # OpenCV's remap rounds positions to 1/32 pixel


@pytest.mark.parametrize("model", ["OPENCV", "OPENCV_FISHEYE"])
def test_undistortion_is_that_of_opencv_half_a_pixel_away(model):
    camera = Camera(model, 160, 120, CAMERAS[model])
    fx, fy, cx, cy, *extra = camera.params
    k = np.array([[fx, 0, cx - 0.5], [0, fy, cy - 0.5], [0, 0, 1]])
    new = np.array([[100.0, 0, 79.5], [0, 100.0, 59.5], [0, 0, 1]])
    make = cv2.initUndistortRectifyMap
    if model == "OPENCV_FISHEYE":
        make = cv2.fisheye.initUndistortRectifyMap
    theirs = make(k, np.array(extra), np.eye(3), new, (160, 120), cv2.CV_32FC1)
    pinhole = Camera("PINHOLE", 160, 120, (100.0, 100.0, 80.0, 60.0))
    ours = undistortion_maps(camera, pinhole, (160, 120))
    for a, b in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(a, b, atol=2e-4)


@pytest.mark.parametrize("model", CAMERAS)
def test_a_straight_image_shows_nothing_from_outside(model):
    camera = Camera(model, 160, 120, CAMERAS[model])
    pinhole = straight(camera)
    assert (pinhole.width, pinhole.height) == (160, 120)
    x, y = undistortion_maps(camera, pinhole, (160, 120))
    assert x.min() > -1.5
    assert x.max() < 160.5
    assert y.min() > -1.5
    assert y.max() < 120.5


def test_stated_size_is_not_the_images():
    """A camera stated at four times the size gives what it gives at the images' own."""
    params = CAMERAS["OPENCV"]
    large = Camera("OPENCV", 640, 480, (*(4 * p for p in params[:4]), *params[4:]))
    own = Lens(Camera("OPENCV", 160, 120, params), (160, 120), 160)
    stated = Lens(large, (160, 120), 160)
    # COLMAP's undistorted size is a whole number, rounded at either size
    np.testing.assert_allclose(stated.intrinsics, own.intrinsics, rtol=0.02)
    difference = np.abs(stated.straighten(picture()).astype(int) - own.straighten(picture()))
    assert difference.mean() < 3


def test_resizing_is_a_mean_and_keeps_corners():
    lens = Lens(Camera("PINHOLE", 160, 120, (150.0, 152.0, 80.0, 61.0)), (160, 120), 40)
    small = lens.straighten(picture())
    boxes = picture().reshape(30, 4, 40, 4, 3).mean(axis=(1, 3))
    assert np.abs(small - boxes).max() <= 0.5
    np.testing.assert_allclose(lens.intrinsics, [37.5, 38, 20, 15.25])


def test_a_factor_that_is_not_whole_scales_each_axis_by_itself():
    lens = Lens(Camera("PINHOLE", 1957, 1091, (1000.0, 1000.0, 978.5, 545.5)), (979, 546), 979)
    assert lens.size == (979, 546)
    np.testing.assert_allclose(
        lens.intrinsics, [1000 * 979 / 1957, 1000 * 546 / 1091, 489.5, 273], rtol=1e-12
    )


def test_masks_are_binary_and_empty_beyond_the_image():
    lens = Lens(Camera("OPENCV_FISHEYE", 160, 120, CAMERAS["OPENCV_FISHEYE"]), (160, 120), 80)
    whole = lens.straighten_mask(np.ones((120, 160), bool))
    assert whole.dtype == bool
    assert whole[2:-2, 2:-2].all()
    half = np.zeros((120, 160), bool)
    half[:, :80] = True
    assert abs(lens.straighten_mask(half).mean() - 0.5) < 0.02


@pytest.mark.parametrize("frame", [(80, 45), (40, 60), (320, 240), (160, 120)])
def test_a_crop_is_the_middle_and_its_camera_sees_the_same_places(frame):
    """A dot whose place the camera tells is there in the crop too."""
    camera = Camera("OPENCV", 160, 120, CAMERAS["OPENCV"])
    ray = np.array([[0.05, -0.04, 1.0]])
    spot = np.asarray(camera.colmap.img_from_cam(ray))[0]
    image = np.zeros((120, 160), np.uint8)
    cv2.circle(image, tuple(np.round(16 * (spot - 0.5)).astype(int)), 16 * 5, 255, -1, shift=4)
    lens = Lens(camera, (160, 120), 999, frame)
    assert lens.size == frame
    shown = lens.straighten(image)
    assert shown.shape == frame[::-1]
    fx, fy, cx, cy = lens.intrinsics
    expected = np.array([fx * 0.05 + cx, -fy * 0.04 + cy])
    mass = np.argwhere(shown > 127)[:, ::-1] + 0.5
    scale = max(1.0, frame[0] / 160)
    np.testing.assert_allclose(mass.mean(axis=0), expected, atol=0.6 * scale)
    assert abs(cx / frame[0] - 0.5) < 0.02  # the middle
    assert fx / fy == pytest.approx(150 / 151, abs=0.02)  # of the same shape
    assert lens.straighten_mask(np.ones((120, 160), bool)).shape == frame[::-1]


def test_the_shape_of_most_cameras_is_the_common_one():
    wide, tall = (Camera("SIMPLE_PINHOLE", *size, (99.0, 1, 1)) for size in ((192, 108), (60, 80)))
    assert common_frame([wide, wide, tall], 96) == (96, 54)
    assert common_frame([tall, wide, tall], 96) == (60, 80)
    assert common_frame([wide, Camera("SIMPLE_PINHOLE", 1920, 1079, (99.0, 1, 1))], 96) is None


def test_other_shapes_and_models_are_refused():
    with pytest.raises(ValueError, match="160x90 but its camera 160x120"):
        Lens(Camera("PINHOLE", 160, 120, (150.0, 150.0, 80.0, 60.0)), (160, 90), 160)
    with pytest.raises(ValueError, match="EQUIRECTANGULAR"):
        straight(Camera("EQUIRECTANGULAR", 160, 120, ()))
