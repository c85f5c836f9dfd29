"""Kills by SIGKILL at random moments: `PYTHONPATH=src:tests python -m fuzz.kills --kills 100`.

Either of `fsel select --force`, or with `--workflow` of a run of the smoke config, which is
continued by the same command until it is whole, and then begun anew until the kills are used up.
Whole results are compared with those of a run that nobody killed.
"""

import argparse
import hashlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd
from small_captures import write_ring

ROOT = Path(__file__).resolve().parents[2]
TIMED = re.compile(r"seconds|peak_bytes")  # columns that no two runs share
OTHERS = {"logs", "benchmarks", "data", "selection.json"}  # data: what captures are read from
LEFT = re.compile(r"\.[^.]+\.\d+\..*|.*\.(journal|partial)")  # unfinished files
SELECT = ["-m", "fsel", "select", "ring", "-k", "6", "--quiet", "--patience", "0", "-o", "out"]


def main():
    """Kill, and say what was found: the exit code is 1 if anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m fuzz.kills")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workflow", action="store_true")
    parser.add_argument("--longest", type=float, default=20.0, help="seconds, of --workflow")
    parser.add_argument("targets", nargs="*", help="of --workflow; all by default")
    asked = parser.parse_args()
    rng = random.Random(asked.seed)
    with tempfile.TemporaryDirectory() as name:
        wrong = (of_workflow if asked.workflow else of_command)(Path(name), asked, rng)
    sys.exit(int(wrong > 0))


def of_command(folder, asked, rng):
    """How many outputs were missing, half or other, or were left beside it."""
    write_ring(folder / "ring", frames=24)
    line = [sys.executable, *SELECT, "--force"]
    subprocess.run(line, cwd=folder, check=True)
    started = time.monotonic()
    subprocess.run(line, cwd=folder, check=True)
    whole, took = of_folder(folder / "out"), time.monotonic() - started
    differing = 0
    for _ in range(asked.kills):
        killed_after(line, folder, rng.uniform(0.1, 0.9) * took, subprocess.DEVNULL)
        differing += of_folder(folder / "out") != whole
    subprocess.run(line, cwd=folder, check=True)
    left = {path.name for path in folder.iterdir()} - {"ring", "out"}
    print(f"{asked.kills} kills; {differing} outputs missing or other; {left=}")
    return differing + len(left)


def of_workflow(folder, asked, rng):
    """How many continued runs failed, or have other results than a run that nobody killed."""
    work = folder / "work"
    code, _ = continued(work, rng, asked, 0)
    whole = of_folder(work / "results")
    print(f"undisturbed: code {code}, {len(whole)} files", flush=True)
    killed = wrong = 0
    while killed < asked.kills:
        shutil.rmtree(work)
        code, kills = continued(work, rng, asked, asked.kills - killed)
        killed += kills
        found = of_folder(work / "results")
        other = sorted(n for n in whole.keys() | found.keys() if whole.get(n) != found.get(n))
        left = [str(p) for p in (work / "results").rglob("*") if LEFT.fullmatch(p.name)]
        wrong += bool(code or other or left)
        print(f"{code=}, {killed} kills so far, {other=}, {left=}", flush=True)
        if code:
            print((work / "said").read_text()[-3000:], flush=True)
    return wrong


def continued(work, rng, asked, kills):
    """Run the smoke config in a folder, killed up to a number of times: exit code, kills done."""
    line = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
    line += ["--configfile", str(ROOT / "config" / "smoke.yaml"), "--cores", "1"]
    line += ["--workflow-profile", str(ROOT / "profiles" / "default"), *asked.targets]
    work.mkdir()
    for done in range(kills + 1):
        seconds = rng.uniform(2, asked.longest) if done < kills else None
        with (work / "said").open("w") as said:
            code = killed_after(line, work, seconds, said)
        if code is not None:
            return code, done
    raise AssertionError("the last run has no limit")


def killed_after(line, folder, seconds, said):
    """Exit code of a command, or None where it was killed after some seconds."""
    process = subprocess.Popen(line, cwd=folder, stdout=said, stderr=said)
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    return None


def of_folder(folder):
    """Relative path -> digest of its content, what no two runs share aside."""
    found = {}
    for path in sorted(item for item in folder.rglob("*") if item.is_file()):
        name = path.relative_to(folder)
        if set(name.parts) & OTHERS:
            continue
        if path.suffix == ".parquet":
            table = pd.read_parquet(path)
            content = table[[column for column in table if not TIMED.search(column)]].to_json()
        else:
            content = "" if path.suffix == ".pdf" else path.read_bytes().hex()  # PDFs have dates
        found[str(name)] = hashlib.sha256(content.encode()).hexdigest()
    return found


if __name__ == "__main__":
    main()
