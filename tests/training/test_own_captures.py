"""The configuration of docs/datasets.md that trains on captures of one's own."""

import re
from pathlib import Path

from dry_runs import dry_run
from small_captures import write_ring

PAGE = Path(__file__).resolve().parents[2] / "docs" / "datasets.md"


def test_the_example_of_the_docs_plans_labels_and_training(tmp_path):
    section = PAGE.read_text().partition("## Train the selector on your own captures")[2]
    config = tmp_path / "mine.yaml"
    config.write_text(re.search(r"```yaml\n(.*?)```", section, re.S)[1])
    for name in ("garden", "hall", "street", "yard"):
        write_ring(tmp_path / "captures" / name, frames=50)
    done = dry_run(tmp_path, config, "results/mine/selector/seed0.safetensors")
    assert done.returncode == 0, done.stdout + done.stderr
    jobs = dict(re.findall(r"^(\w+) +(\d+)$", done.stdout + done.stderr, re.M))
    assert (jobs["ingest"], jobs["label"], jobs["order"], jobs["train"]) == ("3", "15", "1", "1")
