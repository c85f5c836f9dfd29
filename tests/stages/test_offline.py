"""The offline stage on captures in memory and by the workflow's stages: one pipeline."""

import subprocess
import sys

import numpy as np
from small_sweep import RECONSTRUCTION, SEARCH

from fsel.core.capture import Capture
from fsel.core.files import read_table
from fsel.reconstruct import reconstructor_of
from fsel.selectors.policies import KNOWN
from fsel.training.journal import Journal
from fsel.training.labelled import training_data
from fsel.training.labelling import GENETIC
from fsel.training.offline import Described, Labelling, label, tasks
from fsel.training.search import GeneticSettings


def test_both_callers_make_the_same_trajectories(scene, labelled, tmp_path):
    policy = KNOWN["less_is_more"]
    files = {"s": (scene, labelled / "splits.parquet", labelled / "features.parquet")}
    by_stages = training_data(read_table(labelled / "trajectories.parquet"), files, policy)

    capture, table = Capture.load(scene), read_table(scene / "descriptors.parquet")
    appearance = np.stack(table["descriptor"].to_list())
    sharpness = table["sharpness"].to_numpy()
    reconstructor = reconstructor_of(capture, RECONSTRUCTION)
    search = GeneticSettings(**{name: SEARCH[name] for name in GENETIC})
    labelling = Labelling(4, (25,), search, stored=5, kept=2, seed=5)
    described = Described("s", capture, appearance, sharpness, reconstructor)
    (task,) = tasks([described], labelling)
    with Journal(tmp_path / "x", "key") as journal:
        in_memory = list(label(task, labelling, policy, journal))

    assert len(in_memory) == len(by_stages) == 2
    for one, other in zip(in_memory, by_stages, strict=True):
        np.testing.assert_array_equal(one.picks, other.picks)
        np.testing.assert_array_equal(one.selectable, other.selectable)
        assert one.features.tobytes() == other.features.tobytes()
        assert one.weight == other.weight


def test_labels_and_their_order_are_made_without_torch():
    """Importing it takes longer than a label item."""
    imports = "import sys, fsel.stages.label, fsel.stages.order; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", imports], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr
