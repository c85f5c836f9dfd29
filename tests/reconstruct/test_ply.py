"""The standard `.ply` of Gaussians: written, read, and refused by name."""

from dataclasses import replace

import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from fsel.core.capture import Views
from fsel.reconstruct import ply
from fsel.reconstruct.gaussians import GaussianModel
from fsel.reconstruct.gaussians.parameters import width_of
from fsel.reconstruct.selected import Frame

STANDARD = [
    *("x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"),
    *(f"f_rest_{k}" for k in range(24)),
    *("opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"),
]


def cloud(degree, count=7):
    rng = np.random.default_rng(degree)
    return ply.Cloud(
        xyz=rng.normal(size=(count, 3)),
        harmonics=rng.normal(size=(count, (degree + 1) ** 2, 3)),
        logit=rng.normal(size=count),
        log_scale=rng.normal(size=(count, 3)),
        turn=rng.normal(size=(count, 4)),
        background=np.float32([0.25, 0.5, 1 / 3]),
    )


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_what_is_written_is_read(tmp_path, degree):
    written = cloud(degree)
    ply.write(tmp_path / "a.ply", written)
    read = ply.read(tmp_path / "a.ply")
    assert read.degree == degree
    for name in ("xyz", "harmonics", "logit", "log_scale", "turn", "background"):
        expected = getattr(written, name).astype(np.float32)
        np.testing.assert_array_equal(getattr(read, name).astype(np.float32), expected)


def test_the_layout_is_the_standard_one(tmp_path):
    written = cloud(2)
    ply.write(tmp_path / "a.ply", written)
    data = PlyData.read(tmp_path / "a.ply")
    assert [p.name for p in data["vertex"].properties] == STANDARD
    assert (data.byte_order, data.text) == ("<", False)
    # all higher coefficients of red, then of green, then of blue
    assert data["vertex"]["f_rest_0"][3] == np.float32(written.harmonics[3, 1, 0])
    assert data["vertex"]["f_rest_7"][3] == np.float32(written.harmonics[3, 8, 0])
    assert data["vertex"]["f_rest_8"][3] == np.float32(written.harmonics[3, 1, 1])
    assert data["vertex"]["f_dc_2"][3] == np.float32(written.harmonics[3, 0, 2])


def test_text_files_of_doubles_are_read_and_black_is_the_background(tmp_path):
    values = np.zeros(2, [(name, "f8") for name in STANDARD])
    values["x"] = [1.5, 2.5]
    element = PlyElement.describe(values, "vertex")
    PlyData([element], text=True).write(str(tmp_path / "a.ply"))
    read = ply.read(tmp_path / "a.ply")
    assert read.xyz[:, 0].tolist() == [1.5, 2.5]
    assert read.background.tolist() == [0, 0, 0]
    assert read.turn.tolist() == [[1, 0, 0, 0]] * 2


@pytest.mark.parametrize(
    ("lost", "said"),
    [
        *((name, f"no Gaussians: lacks {name}") for name in ("opacity", "f_rest_11", "rot_3")),
        ("", "scale_1 of Gaussian 2 is inf"),
    ],
)
def test_a_missing_column_and_a_value_that_is_not_finite_are_named(tmp_path, lost, said):
    values = np.zeros(3, [(name, "f4") for name in STANDARD if name != lost])
    values["scale_1"][2] = np.inf
    PlyData([PlyElement.describe(values, "vertex")]).write(str(tmp_path / "a.ply"))
    with pytest.raises(ValueError, match=rf"a\.ply: {said}"):
        ply.read(tmp_path / "a.ply")


@pytest.mark.parametrize(
    "content", [b"", b"ply\nformat nonsense 1.0\nend_header\n", b"\xff\xfe\x00", None]
)
def test_what_is_no_ply_is_refused_by_name(tmp_path, content):
    ply.write(tmp_path / "a.ply", cloud(1))
    whole = (tmp_path / "a.ply").read_bytes()
    (tmp_path / "a.ply").write_bytes(whole[:-9] if content is None else content)
    with pytest.raises(ValueError, match=r"a\.ply: no "):
        ply.read(tmp_path / "a.ply")


@pytest.mark.parametrize(
    ("good", "bad", "said"),
    [
        *(("vertex 7", f"vertex {n}", f"{n} rows") for n in (500000000, 2400000000, 10**30)),
        *(("und 0 0 0", f"und {colour}", colour) for colour in ("nan nan nan", "0 inf 0", "0 0 r")),
    ],
)
def test_a_count_beyond_the_file_and_a_background_that_is_no_colour_are_refused(
    tmp_path, good, bad, said
):
    ply.write(tmp_path / "a.ply", replace(cloud(0), background=np.zeros(3)))
    content = (tmp_path / "a.ply").read_bytes()
    (tmp_path / "a.ply").write_bytes(content.replace(good.encode(), bad.encode()))
    with pytest.raises(ValueError, match=rf"a\.ply.*{said}"):
        ply.read(tmp_path / "a.ply")


@pytest.mark.parametrize("degree", [0, 2, 3])
def test_an_exported_model_renders_the_same_when_read(tmp_path, degree):
    rng = np.random.default_rng(0)
    table = rng.normal(0, 0.2, (40, width_of(degree))).astype(np.float32)
    table[:, :3] += [0, 0, 0.5]
    table[:, 3:6] -= 2.5
    table[:, 6] += 1
    unit, origin = 3.0, np.array([20.0, -10.0, 5.0])
    model = GaussianModel(Frame(origin, unit), table, np.float32([0.1, 0.2, 0.3]))
    model.export_ply(tmp_path / "a.ply")
    back = origin - [0, 0, 2 * unit]
    views = Views(
        np.column_stack([np.eye(3), -back])[None], np.array([[30.0, 30.0, 16.0, 12.0]]), (32, 24)
    )
    image = model.render(views)
    assert image.std() > 0.02
    read = GaussianModel.read_ply(tmp_path / "a.ply")
    assert (read.primitives, read.degree) == (40, degree)
    np.testing.assert_allclose(read.render(views), image, atol=2e-5)
    np.testing.assert_allclose(read.positions, model.positions, atol=2e-6)
