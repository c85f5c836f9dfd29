import numpy as np
import pytest
import trimesh

from fsel.synthetic import meshes

PROFILE = [(0, 0), (0.3, 0), (0.5, 0.4), (0.2, 0.9), (0.3, 1.1), (0, 1.2)]
SIZE = (1.0, 2.0, 0.7)
CORNERS = [(-0.5, -1, 0), (0.5, -1, 0), (0.5, 1, 0), (-0.5, 1, 0), (0, -1, 0.7), (0, 1, 0.7)]
SAME = {
    "box": (meshes.box(SIZE), trimesh.creation.box(SIZE)),
    "gable": (meshes.gable(SIZE), trimesh.convex.convex_hull(np.array(CORNERS))),
    "cylinder": (meshes.cylinder(0.4, 1.5), trimesh.creation.cylinder(0.4, 1.5, sections=24)),
    "lathe": (meshes.lathe(PROFILE, 32), trimesh.creation.revolve(PROFILE, sections=32)),
    "sphere": (meshes.sphere(2), trimesh.creation.icosphere(2)),
    "finer sphere": (meshes.sphere(3), trimesh.creation.icosphere(3)),
}


def corners(mesh):
    """Its distinct corners, sorted; a corner that no face has does not count."""
    used = mesh.vertices[np.unique(mesh.faces)]
    return np.unique(used.round(9) + 0.0, axis=0)


@pytest.mark.parametrize("name", SAME)
def test_meshes_are_those_of_a_mesh_library(name):
    mine, theirs = SAME[name]
    np.testing.assert_allclose(corners(mine), corners(theirs), atol=1e-9)
    solid = trimesh.Trimesh(mine.vertices, mine.faces)
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert solid.volume == pytest.approx(theirs.volume)  # negative, were the normals inwards
    assert solid.area == pytest.approx(theirs.area)


def test_a_placed_mesh_is_turned_about_its_vertical_axis_and_moved():
    placed = meshes.box((2, 4, 6)).scaled((1, 1, 0.5)).placed((10, 20, 30), np.pi / 2)
    np.testing.assert_allclose(np.ptp(placed.vertices, axis=0), [4, 2, 3])
    np.testing.assert_allclose(placed.vertices.mean(axis=0), [10, 20, 30])
    first = meshes.Mesh(np.array([[1.0, 0, 0]]), np.empty((0, 3), int)).placed((0, 0, 0), np.pi / 2)
    np.testing.assert_allclose(first.vertices, [[0, 1, 0]], atol=1e-15)


def test_what_was_up_lies_along_x():
    np.testing.assert_array_equal(
        meshes.Mesh(np.array([[1.0, 2, 3]]), None).lying().vertices, [[3, 2, -1]]
    )
