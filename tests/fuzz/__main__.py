"""The long run: `PYTHONPATH=src:tests python -m fuzz --cases 20000`.

Prints a line a failure, whose kind and seed make an entry of cases.json, and the counts at the end.
"""

import argparse
import json
import resource
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tqdm import tqdm

from fsel.cli import stderr_filter

from . import cases, originals

MEMORY = "/dev/shm"  # where there is one: most of a case's time goes into small files


def main():
    """Run, and say how many went wrong: the exit code is 1 if any did."""
    parser = argparse.ArgumentParser(prog="python -m fuzz")
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    counts = Counter()
    place = MEMORY if Path(MEMORY).is_dir() else None
    with stderr_filter(), tempfile.TemporaryDirectory(dir=place) as name:
        original, work = Path(name, "originals"), Path(name, "work")
        originals.write(original)
        cases.warm_up(originals.KINDS, original, work)
        for case in tqdm(cases.drawn(asked.cases, asked.seed), disable=None):
            # a second time: a busy machine may be slow once
            wrong = cases.run(case, original, work) and cases.run(case, original, work)
            counts["wrong" if wrong else "right"] += 1
            if wrong:
                print(json.dumps([case.kind, case.seed, None]), wrong[0][:600], flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    done = counts.total()
    print(f"{done} cases, {counts['wrong']} wrong, peak of memory {peak:.2f} GB")
    print(f"the next one is --seed {asked.seed + done}")
    return int(counts["wrong"] > 0)


sys.exit(main())
