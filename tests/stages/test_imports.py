"""Jobs with little to do import nothing that takes longer than they do."""

from own_python import printed

PROGRAM = """
import sys
from pathlib import Path
import fsel.stages.ingest, fsel.stages.label, fsel.stages.search_oracle
from fsel.metrics import METRICS
from fsel.stages.describe import describe
from fsel.stages.evaluate import evaluate
from fsel.stages.features import features
from fsel.stages.order import order
from fsel.stages.select import select
from fsel.stages.split import split, split_labelled

scene, labelled, out = map(Path, sys.argv[1:])
files = [out / f"{name}.parquet" for name in ("split", "features", "selections", "evaluation")]
describe(scene, out / "described.parquet", kind="lab_hog", weights=None, config="c")
split(scene, files[:1], targets=4, seed=1, config="c")
split_labelled(scene, out / "splits.parquet", coverages=[25], seed=1, config="c")
features(scene, files[:1], files[1:2], config="c")
select(scene, files[:1], files[1:2], [], files[2:3], budgets=[3], seeds=[2], config="c")
splats = {"name": "splats", "long_side": 32, "settings": {}}
only = {"reconstruction": splats, "metrics": METRICS, "only": {"method": ["nearest"]}}
evaluate(scene, files[:1], files[2:3], files[3:], **only, config="c")
parts = [[labelled / f"{name}.parquet"] for name in ("splits", "features", "p25")]
roles = {"scenes": {"s": "train"}, "coverages": {"s": [25]}}
order([scene], *parts, out / "trajectories.parquet", **roles, kept=2, config="c")
print(*{"pandas", "torch"} & set(sys.modules))
"""


def test_neither_pandas_nor_torch(scene, labelled, tmp_path):
    assert printed(PROGRAM, scene, labelled, tmp_path).split() == []
