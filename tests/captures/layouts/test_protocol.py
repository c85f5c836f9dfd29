"""DL3DV's protocol: held-out eighths and listed inputs, by their places in transforms.json."""

import json
from dataclasses import replace

import numpy as np
import pytest
from layout_recordings import write_recording
from selection_problems import problem_on

import fsel
from fsel.captures.layouts import dl3dv
from fsel.captures.layouts.dl3dv import read_protocol
from fsel.core.problem import checked_select
from fsel.core.split import Split
from fsel.stages.split import split

FRAMES = 80
FREE = [place for place in range(FRAMES) if place % 8]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A scene, its capture, and the names in the order of its transforms.json."""
    folder = tmp_path_factory.mktemp("dl3dv") / "abc"
    write_recording("dl3dv", folder, frames=FRAMES)
    return folder, fsel.read_capture(folder, long_side=32), dl3dv.frame_order(folder)


def listed(folder, **lists):
    path = folder / "list.json"
    path.write_text(json.dumps([{"scene_name": "other"}, {"scene_name": "abc", **lists}]))
    return path


def test_places_count_in_transforms_json(scene, tmp_path):
    folder, capture, order = scene
    assert sorted(order) != order  # as the benchmark's, it need not be the capture's order
    places = FREE[::5]
    file = listed(tmp_path, fold_8_kmeans_14_input=places, fold_8_other=[0])
    protocol = read_protocol(file, "abc", folder, capture.names)
    names = np.array(capture.names)
    assert set(names[protocol.targets]) == set(order[::8])
    assert list(protocol.inputs) == [14]
    assert set(names[protocol.inputs[14]]) == {order[place] for place in places}


def test_the_split_and_the_method_are_the_protocol_s(scene, tmp_path):
    folder, capture, _ = scene
    file = listed(tmp_path, fold_8_kmeans_14_input=FREE[::5])
    given = {"file": str(file), "scene": "abc", "folder": str(folder)}
    where = tmp_path / "canonical"
    capture.save(where)
    split(where, [tmp_path / "s.parquet"], targets=4, seed=1, protocol=given, config="c")
    made = Split.load(tmp_path / "s.parquet")
    protocol = read_protocol(**given, names=capture.names)
    np.testing.assert_array_equal(made.targets, protocol.targets)
    assert len(made.proxies) == len(made.targets) == 10
    problem = replace(problem_on(capture), proxies=made.proxies, candidates=made.candidates)
    picks = checked_select(protocol.method, problem, 14, np.random.default_rng(0))
    np.testing.assert_array_equal(picks, protocol.inputs[14])


@pytest.mark.parametrize(
    ("lists", "name", "said"),
    [
        ({"fold_8_kmeans_2_input": [1, 80]}, "abc", r"_2_input: places \[80\]; allowed"),
        ({"fold_8_kmeans_2_input": [1, 8]}, "abc", "are held out"),
        ({}, "abd", "no scene abd among its 2"),
    ],
)
def test_wrong_lists_are_refused(scene, tmp_path, lists, name, said):
    folder, capture, _ = scene
    with pytest.raises(ValueError, match=said):
        read_protocol(listed(tmp_path, **lists), name, folder, capture.names)


def test_what_is_no_list_or_lacks_frames_is_refused(scene, tmp_path):
    folder, capture, order = scene
    (tmp_path / "no.json").write_text("{}")
    (tmp_path / "wrong.json").write_text('[{"scene": 1}]')
    for file in ("no.json", "wrong.json"):
        with pytest.raises(ValueError, match=r"(list of objects|'scene_name' is missing)"):
            read_protocol(tmp_path / file, "abc", folder, capture.names)
    fewer = [name for name in capture.names if name != order[8]]
    with pytest.raises(ValueError, match=r"held-out frames: .* are not among the capture's 79"):
        read_protocol(listed(tmp_path), "abc", folder, fewer)
