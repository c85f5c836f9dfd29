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
XYZ = np.random.default_rng(0).uniform(-1, 1, (40, 3))
BROWN = {"k1": -0.05, "k2": 0.01, "k3": 2e-3}
FAR = np.array([4e5, 5e6, 100.0])  # metres, of a grid that covers a country


def images(folder, names):
    noise = np.random.default_rng(0).integers(0, 255, (len(names), *SIZE[::-1], 3), np.uint8)
    image_files.write(noise, folder, names)


def truth(fx=FX, fy=FY, cx=CX, cy=CY, k1=0, k2=0, k3=0, k4=0, along=0, across=0, fisheye=False):
    """(12, 40, 2) pixels of the points, by the formulas of the programs' manuals.

    `along` is what multiplies r^2 + 2 x^2 in x, `across` r^2 + 2 y^2 in y.
    """
    seen = []
    for pose in POSES:
        local = XYZ @ pose[:, :3].T + pose[:, 3]
        x, y = local[:, 0] / local[:, 2], local[:, 1] / local[:, 2]
        if fisheye:
            r = np.hypot(x, y)
            x, y = x / r * np.arctan(r), y / r * np.arctan(r)
        r2 = x * x + y * y
        radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3 + k4 * r2**4
        u = x * radial + along * (r2 + 2 * x * x) + 2 * across * x * y
        v = y * radial + across * (r2 + 2 * y * y) + 2 * along * x * y
        seen.append(np.stack([u * fx + cx, v * fy + cy], axis=1))
    return np.array(seen)


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
    for i, (name, pose) in enumerate(zip(names, POSES, strict=True)):
        known = {f"t_{r}{c}": opengl(pose)[r, c] for r in range(3) for c in range(4)}
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
    quaternions = Rotation.from_matrix([opengl(pose)[:3, :3] for pose in POSES]).as_quat()
    places = [opengl(pose)[:3, 3] for pose in POSES]
    poses = np.column_stack([quaternions, places]).tolist()
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


def metashape(folder, kind="frame", cameras="", world=None, **terms):
    """Labels without endings; a chunk that is turned, scaled and far away by `world`."""
    names = [f"IMG.{i:02d}" for i in range(12)]
    images(folder / "images", [f"{name}.JPG" for name in names])
    turn, scale, shift = world or (np.eye(3), 1, np.zeros(3))
    values = {"f": FX, "cx": CX - SIZE[0] / 2, "cy": CY - SIZE[1] / 2} | terms
    lens = "".join(f"<{key}>{value!r}</{key}>" for key, value in values.items())
    written = "".join(
        f'<camera id="{i}" sensor_id="0" component_id="0" label="{name}"><transform>'
        f"{' '.join(map(repr, (opengl(pose) @ np.diag([1, -1, -1, 1])).ravel().tolist()))}"
        "</transform></camera>"
        for i, (name, pose) in enumerate(zip(names, POSES, strict=True))
    )
    numbers = (" ".join(map(repr, np.ravel(part).tolist())) for part in (turn, shift))
    turned, shifted = numbers
    (folder / "cameras.xml").write_text(
        f'<document version="2.0.0"><chunk label="1"><sensors><sensor id="0" type="{kind}">'
        f'<resolution width="{SIZE[0]}" height="{SIZE[1]}"/>'
        '<calibration class="initial"><f>1</f></calibration>'
        f'<calibration class="adjusted">{lens}</calibration></sensor></sensors>'
        f"<cameras><group>{written}{cameras}</group></cameras><transform>"
        f"<rotation>{turned}</rotation><translation>{shifted}</translation>"
        f"<scale>{scale!r}</scale></transform></chunk></document>"
    )


def test_metashape(tmp_path):
    one = '<camera sensor_id="0" label="{}" component_id="{}" {}>{}</camera>'
    there = "<transform>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</transform>"
    others = [("a", 0, "", ""), ("b", 0, 'enabled="false"', there), ("c", 1, "", there)]
    turn, scale = Rotation.random(rng=np.random.default_rng(1)).as_matrix(), 2.5
    terms = BROWN | {"p1": 3e-4, "p2": -4e-4, "b1": FY - FX, "f": FX}
    written = "".join(one.format(*other) for other in others)
    metashape(tmp_path, "frame", written, (turn, scale, FAR), **terms)
    expected = truth(FY, FX, **BROWN, along=3e-4, across=-4e-4)
    far = scale * np.median([opengl(pose)[:3, 3] for pose in POSES], axis=0) @ turn.T + FAR
    near = FAR - np.round(far)  # the world is moved to its cameras
    raw = agrees(tmp_path, "metashape", expected, lambda xyz: scale * xyz @ turn.T + near)
    left = ["not aligned", "disabled", "in a smaller component"]
    assert raw.dropped == dict(zip("abc", left, strict=True))
    assert raw.names[0] == "IMG.00.JPG"


def test_metashape_fisheye(tmp_path):
    metashape(tmp_path, "fisheye", k1=-0.03, k2=6e-3, k4=1e-3, p1=3e-4)
    agrees(
        tmp_path, "metashape", truth(fy=FX, k1=-0.03, k2=6e-3, k4=1e-3, along=3e-4, fisheye=True)
    )
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
    side = max(SIZE)
    head = "yaw,pitch,roll,f_35mm,px_norm,py_norm" if newer else "heading,pitch,roll,f,px,py"
    lines = ["#cameras 12", f"#name,x,y,alt,{head},k1,k2,k3,k4,t1,t2"]
    for i, pose in enumerate(POSES):
        turn = Rotation.from_matrix(opengl(pose)[:3, :3]).as_euler("ZXY", degrees=True)
        place = opengl(pose)[:3, 3] + FAR
        lens = [FX * 36 / side, (CX - SIZE[0] / 2) / side, (CY - SIZE[1] / 2) / side]
        row = [*place, -turn[0], *turn[1:], *lens, *BROWN.values(), 0, 3e-4, -4e-4]
        lines.append(",".join([f"{i}.jpg", *(repr(float(number)) for number in row)]))
    (tmp_path / "cameras.csv").write_text("\n".join(lines))
    near = FAR - np.round(np.median([opengl(pose)[:3, 3] + FAR for pose in POSES], axis=0))
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
    side = max(SIZE)
    known = {"projection_type": kind, "width": SIZE[0], "height": SIZE[1]} | lens
    if "focal" in lens:
        expected |= {"fx": side, "fy": side}
    else:
        known |= {"focal_x": FX / side, "focal_y": FY / side}
        known |= {"c_x": (CX - SIZE[0] / 2) / side, "c_y": (CY - SIZE[1] / 2) / side}
    names = [f"DJI_{i:04d}.JPG" for i in range(12)]
    images(tmp_path / "images", names)
    seen = truth(**expected)
    shots = {
        name: {
            "rotation": Rotation.from_matrix(pose[:, :3]).as_rotvec().tolist(),
            "translation": pose[:, 3].tolist(),
            "camera": "v2 dji",
        }
        for name, pose in zip(names, POSES, strict=True)
    }
    points = {
        str(7 + i): {"coordinates": row, "color": [9.5, 0, 255]}
        for i, row in enumerate(XYZ.tolist())
    }
    whole = {"cameras": {"v2 dji": known}, "shots": shots, "points": points}
    small = {"cameras": {}, "shots": {"lost.JPG": shots[names[0]]}}
    (tmp_path / "opensfm").mkdir()
    (tmp_path / "opensfm" / "reconstruction.json").write_text(json.dumps([small, whole]))
    rows = ["OPENSFM_TRACKS_VERSION_v2"]
    for name, frame in zip([*names, "lost.JPG"], [*seen, seen[0]], strict=True):
        places = (frame - np.array(SIZE) / 2) / side
        rows += [
            f"{name}\t{7 + i}\t0\t{x!r}\t{y!r}\t1\t0\t0\t0"
            for i, (x, y) in enumerate(places.tolist())
        ]
    (tmp_path / "opensfm" / "tracks.csv").write_text("\n".join(rows))
    raw = agrees(tmp_path, "opensfm", seen)
    assert raw.dropped == {"lost.JPG": "in a smaller reconstruction"}
    sparse = raw.sparse()
    np.testing.assert_allclose(sparse.track_xy, seen.reshape(-1, 2), atol=1e-9)
    np.testing.assert_array_equal(sparse.rgb[0], [9, 0, 255])
    assert read_capture(tmp_path).points is not None
    known["projection_type"] = "spherical"
    (tmp_path / "opensfm" / "reconstruction.json").write_text(json.dumps([whole]))
    with pytest.raises(ValueError, match=r"'spherical'; allowed: perspective, "):
        read_raw(tmp_path)
