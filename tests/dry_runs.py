"""Experiments of changed configurations, and dry runs of the workflow."""

import copy
import json
import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from tempfile import NamedTemporaryFile

import yaml

from fsel.workflow.experiment import Experiment

ROOT = Path(__file__).resolve().parents[1]
READ: list[bytes] = []
SMOKE = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())


def experiment(**changes) -> Experiment:
    """The smoke config's with some top-level keys replaced."""
    return Experiment.load(copy.deepcopy(SMOKE | changes), ROOT.joinpath)


def with_dataset(**entry) -> dict:
    """The smoke config's datasets and one more, `mine`."""
    return SMOKE["datasets"] | {"mine": {"label": "Mine"} | entry}


def dry_run(folder: Path, config: Path, *targets: str) -> subprocess.CompletedProcess:
    """`snakemake --dry-run` in an empty folder."""
    return snakemake(folder, [config], "--dry-run", *targets)


def snakemake(folder: Path, configs: Sequence[Path], *words: str) -> subprocess.CompletedProcess:
    """The workflow with some configurations, later ones over earlier, in a folder."""
    line = ["--snakefile", str(ROOT / "Snakefile"), "--configfile", *map(str, configs)]
    return forked(folder, *line, "--workflow-profile", "none", *words)


def forked(folder: Path, *words: str) -> subprocess.CompletedProcess:
    """`snakemake WORDS` in a folder, see `forked_snakemake`.

    What the first run found in the sources of this checkout, the runs in other folders are given.
    """
    server, variables = _server(), {**os.environ, "PYTHONWARNINGS": "ignore", "PIP_NO_INDEX": "1"}
    kept, own = folder / ".snakemake" / "library.json", str(ROOT / "Snakefile") in words
    if own and READ and not kept.exists():
        kept.parent.mkdir(exist_ok=True)
        kept.write_bytes(READ[0])
    with NamedTemporaryFile("r") as out, NamedTemporaryFile("r") as err:
        asked = [str(folder), words, variables, [out.name, err.name]]
        print(json.dumps(asked), file=server.stdin, flush=True)
        code = int(server.stdout.readline())
        if own and kept.exists():
            READ[:] = [kept.read_bytes()]
        return subprocess.CompletedProcess(words, code, out.read(), err.read())


@cache
def _server() -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-W", "ignore", Path(__file__).with_name("forked_snakemake.py")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def planned(result: subprocess.CompletedProcess) -> Counter:
    """rule -> number of jobs."""
    assert result.returncode == 0, result.stdout + result.stderr
    stats = (result.stdout + result.stderr).split("Job stats:")[1]
    return Counter({name: int(n) for name, n in re.findall(r"^(\w+) +(\d+)$", stats, re.M)})


def changed(folder: Path, **changes) -> Path:
    """The smoke config with some top-level keys replaced."""
    path = folder / "config.yaml"
    path.write_text(yaml.safe_dump(SMOKE | changes))
    return path


def refusal(folder: Path, config: Path) -> str:
    result = dry_run(folder, config)
    assert result.returncode != 0
    return result.stdout + result.stderr
