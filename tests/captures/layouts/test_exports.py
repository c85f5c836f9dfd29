"""What phones and photogrammetry programs export, written by their definitions and read back."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_captures import opengl, ring

from fsel.captures.images import files as image_files
from fsel.captures.read import read_capture, read_raw, recognise

SIZE = (48, 64)  # upright, as of a phone
FX, FY, CX, CY = 60.0, 61.0, 25.0, 31.0
POSES = ring(12)
PLACED = np.array([opengl(pose) for pose in POSES])  # camera to world, OpenGL axes
TURNED, CENTERS = Rotation.from_matrix(PLACED[:, :3, :3]), PLACED[:, :3, 3]
SIDE = max(SIZE)
OFF = {"x": CX - SIZE[0] / 2, "y": CY - SIZE[1] / 2}  # of the principal point from the middle
XYZ = np.random.default_rng(0).uniform(-1, 1, (40, 3))
CAMERA = '<camera sensor_id="0" label="{}" component_id="{}" {}>{}</camera>'
BROWN = {"k1": -0.05, "k2": 0.01, "k3": 2e-3}
FAR = np.array([4e5, 5e6, 100.0])  # metres, of a grid that covers a country


def images(folder, names):
    noise = np.random.default_rng(0).integers(0, 255, (len(names), *SIZE[::-1], 3), np.uint8)
    image_files.write(noise, folder, names)


def truth(fx=FX, fy=FY, cx=CX, cy=CY, k1=0, k2=0, k3=0, k4=0, along=0, across=0, fisheye=False):
    """(12, 40, 2) pixels of the points, by the formulas of the programs' manuals.

    `along` is what multiplies r^2 + 2 x^2 in x, `across` r^2 + 2 y^2 in y.
    """
    x, y, z = np.moveaxis(XYZ @ POSES[:, :, :3].transpose(0, 2, 1) + POSES[:, None, :, 3], 2, 0)
    x, y = x / z, y / z
    if fisheye:
        r = np.hypot(x, y)
        x, y = x / r * np.arctan(r), y / r * np.arctan(r)
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3 + k4 * r2**4
    u = x * radial + along * (r2 + 2 * x * x) + 2 * across * x * y
    v = y * radial + across * (r2 + 2 * y * y) + 2 * along * x * y
    return np.stack([u * fx + cx, v * fy + cy], axis=2)


def agrees(folder, layout, expected, world=lambda xyz: xyz, **reading):
    """Read a folder as recognised; its points, in its world, lie at the expected pixels."""
    assert recognise(folder)[0] == layout
    raw = read_raw(folder, reading=reading)[1]
    seen = [raw.projected(frame, world(XYZ))[1] for frame in range(len(raw.names))]
    np.testing.assert_allclose(seen, expected, atol=1e-6)
    assert len(read_capture(folder, reading=reading, max_error=9)) == len(expected)
    return raw


def polycam(folder, kind="corrected_", **content):
    names = [str(1000 + i) for i in range(12)]
    images(folder / "keyframes" / f"{kind}images", [f"{name}.jpg" for name in names])
    cameras = folder / "keyframes" / f"{kind}cameras"
    cameras.mkdir()
    for i, name in enumerate(names):
        known = {f"t_{r}{c}": PLACED[i, r, c] for r in range(3) for c in range(4)}
        known |= {"fx": FX, "fy": FY, "cx": CX, "cy": CY, "width": SIZE[0], "height": SIZE[1]}
        text = json.dumps(known | {"blur_score": 10.0 * i, "neighbors": [1001]} | content)
        (cameras / f"{name}.json").write_text(text)


def test_polycam(tmp_path):
    polycam(tmp_path, kind="", fx=99)
    polycam(tmp_path)  # the corrected ones are preferred
    agrees(tmp_path, "polycam", truth())
    raw = agrees(tmp_path, "polycam", truth()[3:], min_blur_score=30)
    assert raw.dropped == dict.fromkeys(["1000.jpg", "1001.jpg", "1002.jpg"], "blur_score below 30")
    path = tmp_path / "keyframes" / "corrected_cameras" / "1004.json"
    path.write_text("{}")
    with pytest.raises(ValueError, match=r"1004\.json: field 't_00' is missing"):
        read_raw(tmp_path)
    path.unlink()
    assert read_raw(tmp_path)[1].dropped == {"1004.jpg": "no camera of this name"}


@pytest.mark.parametrize(
    ("name", "inner"), [("EXR_RGBD/metadata.json", "rgb"), ("metadata", "rgbd")]
)
def test_record3d(tmp_path, name, inner):
    path = tmp_path / name
    images(path.parent / inner, [f"{i}.jpg" for i in range(12)])
    poses = np.column_stack([TURNED.as_quat(), CENTERS]).tolist()
    content = {"w": SIZE[0], "h": SIZE[1], "K": [FX, 0, 0, 0, FY, 0, CX, CY, 1], "fps": 60}
    path.write_text(json.dumps(content | {"poses": [*poses, poses[0]]}))
    raw = agrees(tmp_path, "record3d", truth())
    assert raw.dropped == {"12": "no image was exported"}
    lenses = [[FX + 1, FY, CX, CY]] * 12  # autofocus
    path.write_text(json.dumps(content | {"poses": poses, "perFrameIntrinsicCoeffs": lenses}))
    agrees(tmp_path, "record3d", truth(fx=FX + 1))
    poses[5][:4] = [0, 0, 0, 0]
    path.write_text(json.dumps(content | {"poses": poses}))
    with pytest.raises(ValueError, match=r"poses\[5\] has a quaternion of length 0.*allowed: 1"):
        read_raw(tmp_path)


def in_words(numbers):
    return " ".join(map(repr, np.ravel(numbers).tolist()))


def metashape(
    folder,
    kind="frame",
    cameras="",
    turn=(1, 0, 0, 0, 1, 0, 0, 0, 1),
    scale=1,
    shift=(0, 0, 0),
    **terms,
):
    """Labels without endings; a chunk that is turned, scaled and shifted."""
    names = [f"IMG.{i:02d}" for i in range(12)]
    images(folder / "images", [f"{name}.JPG" for name in names])
    values = {"f": FX, "cx": OFF["x"], "cy": OFF["y"]} | terms
    lens = "".join(f"<{key}>{value!r}</{key}>" for key, value in values.items())
    for name, placed in zip(names, PLACED @ np.diag([1, -1, -1, 1]), strict=True):
        cameras += CAMERA.format(name, 0, "", f"<transform>{in_words(placed)}</transform>")
    (folder / "cameras.xml").write_text(
        f'<document version="2.0.0"><chunk label="1"><sensors><sensor id="0" type="{kind}">'
        f'<resolution width="{SIZE[0]}" height="{SIZE[1]}"/>'
        '<calibration class="initial"><f>1</f></calibration>'
        f'<calibration class="adjusted">{lens}</calibration></sensor></sensors>'
        f"<cameras><group>{cameras}</group></cameras><transform><rotation>{in_words(turn)}"
        f"</rotation><translation>{in_words(shift)}</translation><scale>{scale!r}</scale>"
        "</transform></chunk></document>"
    )


def test_metashape(tmp_path):
    there = "<transform>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</transform>"
    others = [("a", 0, "", ""), ("b", 0, 'enabled="false"', there), ("c", 1, "", there)]
    turn, scale = Rotation.random(rng=np.random.default_rng(1)).as_matrix(), 2.5
    terms = BROWN | {"p1": 3e-4, "p2": -4e-4, "b1": FY - FX, "f": FX}
    written = "".join(CAMERA.format(*other) for other in others)
    metashape(tmp_path, "frame", written, turn, scale, FAR, **terms)
    expected = truth(FY, FX, **BROWN, along=3e-4, across=-4e-4)
    far = scale * np.median(CENTERS, axis=0) @ turn.T + FAR
    near = FAR - np.round(far)  # the world is moved to its cameras
    raw = agrees(tmp_path, "metashape", expected, lambda xyz: scale * xyz @ turn.T + near)
    left = ["not aligned", "disabled", "in a smaller component"]
    assert raw.dropped == dict(zip("abc", left, strict=True))
    assert raw.names[0] == "IMG.00.JPG"


def test_metashape_fisheye(tmp_path):
    terms = {"k1": -0.03, "k2": 6e-3, "k4": 1e-3}
    metashape(tmp_path, "fisheye", **terms, p1=3e-4)
    agrees(tmp_path, "metashape", truth(fy=FX, **terms, along=3e-4, fisheye=True))
    metashape(tmp_path, "fisheye", k1=-0.03)
    agrees(tmp_path, "metashape", truth(fy=FX, k1=-0.03, fisheye=True))
    metashape(tmp_path, "spherical")
    with pytest.raises(ValueError, match=r"type 'spherical'; allowed: frame or fisheye"):
        read_raw(tmp_path)
    metashape(tmp_path, k4=5.0)
    with pytest.raises(ValueError, match=r"k4 of sensor 0 moves .* pixels; allowed: below 0.5"):
        read_raw(tmp_path)


@pytest.mark.parametrize("newer", [False, True])
def test_realityscan(tmp_path, newer):
    images(tmp_path, [f"{i}.png" for i in range(12)])
    head = "yaw,pitch,roll,f_35mm,px_norm,py_norm" if newer else "heading,pitch,roll,f,px,py"
    lines = ["#cameras 12", f"#name,x,y,alt,{head},k1,k2,k3,k4,t1,t2"]
    lens = [FX * 36 / SIDE, OFF["x"] / SIDE, OFF["y"] / SIDE, *BROWN.values(), 0, 3e-4, -4e-4]
    angles = TURNED.as_euler("ZXY", degrees=True) * [-1, 1, 1]
    for i, row in enumerate(np.hstack([CENTERS + FAR, angles, np.tile(lens, (12, 1))])):
        lines.append(f"{i}.jpg," + in_words(row).replace(" ", ","))
    (tmp_path / "cameras.csv").write_text("\n".join(lines))
    near = FAR - np.round(np.median(CENTERS + FAR, axis=0))
    expected = truth(fy=FX, **BROWN, along=3e-4, across=-4e-4)
    agrees(tmp_path, "realityscan", expected, lambda xyz: xyz + near)
    (tmp_path / "5.png").unlink()
    assert len(read_capture(tmp_path, skip_unreadable=True, max_error=9)) == 11
    (tmp_path / "cameras.csv").write_text("\n".join([*lines[:2], "a.png,1"]))
    with pytest.raises(ValueError, match=r"cameras\.csv: a\.png: field 'y' is missing"):
        read_raw(tmp_path)


@pytest.mark.parametrize(
    ("kind", "lens", "expected"),
    [
        ("perspective", {"focal": 1.0, "k1": -0.05}, {"cx": 24, "cy": 32, "k1": -0.05}),
        ("brown", BROWN | {"p1": 3e-4, "p2": -4e-4}, BROWN | {"along": -4e-4, "across": 3e-4}),
        ("fisheye_opencv", {"k1": -0.03}, {"k1": -0.03, "fisheye": True}),
    ],
)
def test_opensfm(tmp_path, kind, lens, expected):
    known = {"projection_type": kind, "width": SIZE[0], "height": SIZE[1]} | lens
    if "focal" in lens:
        expected |= {"fx": SIDE, "fy": SIDE}
    else:
        known |= {"focal_x": FX / SIDE, "focal_y": FY / SIDE}
        known |= {"c_x": OFF["x"] / SIDE, "c_y": OFF["y"] / SIDE}
    names, seen = [f"DJI_{i:04d}.JPG" for i in range(12)], truth(**expected)
    images(tmp_path / "images", names)
    turns = Rotation.from_matrix(POSES[:, :, :3]).as_rotvec().tolist()
    shots = {
        name: {"rotation": turn, "translation": shift, "camera": "v2 dji"}
        for name, turn, shift in zip(names, turns, POSES[:, :, 3].tolist(), strict=True)
    }
    color = {"color": [9.5, 0, 255]}
    points = {str(7 + i): color | {"coordinates": row} for i, row in enumerate(XYZ.tolist())}
    whole = {"cameras": {"v2 dji": known}, "shots": shots, "points": points}
    small = {"cameras": {}, "shots": {"lost.JPG": shots[names[0]]}}
    path = tmp_path / "opensfm" / "reconstruction.json"
    path.parent.mkdir()
    path.write_text(json.dumps([small, whole]))
    rows = ["OPENSFM_TRACKS_VERSION_v2"]
    for name, frame in zip([*names, "lost.JPG"], [*seen, seen[0]], strict=True):
        for i, place in enumerate((frame - np.array(SIZE) / 2) / SIDE):
            rows.append(f"{name}\t{7 + i}\t0\t{in_words(place)}\t1\t0\t0\t0".replace(" ", "\t"))
    path.with_name("tracks.csv").write_text("\n".join(rows))
    raw = agrees(tmp_path, "opensfm", seen)
    assert raw.dropped == {"lost.JPG": "in a smaller reconstruction"}
    sparse = raw.sparse()
    np.testing.assert_allclose(sparse.track_xy, seen.reshape(-1, 2), atol=1e-9)
    np.testing.assert_array_equal(sparse.rgb[0], [9, 0, 255])
    assert read_capture(tmp_path).points is not None
    known["projection_type"] = "spherical"
    path.write_text(json.dumps([whole]))
    with pytest.raises(ValueError, match=r"'spherical'; allowed: perspective, "):
        read_raw(tmp_path)
