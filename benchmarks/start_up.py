"""What a job of the workflow costs where there is little to do: start-up, mostly.

    python benchmarks/start_up.py [--beside CHECKOUT] [--repeats 10]

Runs the smoke workflow in an empty folder, a minute, then the script of one job of each rule again
and again, in turns by the library of this checkout and by that of another. Prints medians of
seconds of the processor, user and system, on one thread; what is compiled is compiled before.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from fsel.workflow.machine import prepare

ROOT = Path(__file__).parents[1]
RULES = (
    "generate",
    "ingest",
    "describe",
    "split",
    "features",
    "order",
    "select",
    "evaluate",
    "ksweep",
)
BODY = re.compile(r"(?<=preamble end #########\n).*", re.S)


def scripts(folder: Path) -> dict[str, str]:
    """Rule -> the script of one of its jobs, from a run of the smoke workflow in a folder."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
    command += ["--configfile", str(ROOT / "config" / "smoke.yaml"), "--cores", "1"]
    done = subprocess.run(
        [*command, "--skip-script-cleanup"], cwd=folder, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit(done.stderr[-2000:])
    texts = [path.read_text() for path in sorted((folder / ".snakemake" / "scripts").glob("*.py"))]
    return {
        rule: next(t for t in texts if f"/logs/{rule}/" in t or f"/{rule}.log" in t)
        for rule in RULES
    }


def seconds(script: str, checkout: Path, folder: Path) -> float:
    """Processor seconds of a job by the library of a checkout."""
    body = (checkout / "workflow" / "scripts" / "run.py").read_text()
    path = folder / "job.py"
    path.write_text(BODY.sub(lambda found: body, script))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    variables = {**os.environ, "PYTHONPATH": str(checkout / "src"), "OMP_NUM_THREADS": "1"}
    subprocess.run([sys.executable, str(path)], cwd=folder, env=variables, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--beside", type=Path, default=None)
    parser.add_argument("--repeats", type=int, default=10)
    asked = parser.parse_args()
    checkouts = [ROOT, *([asked.beside.resolve()] if asked.beside else [])]
    prepare()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for rule, script in scripts(folder).items():
            spent = [
                [seconds(script, c, folder) for c in checkouts] for _ in range(asked.repeats + 1)
            ]
            medians = np.median(spent[1:], axis=0)  # the first may compile
            print(f"{rule:10s}" + "".join(f"{median:7.2f} s" for median in medians), flush=True)


if __name__ == "__main__":
    main()
