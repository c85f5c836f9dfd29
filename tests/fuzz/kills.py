"""Kills by SIGKILL at random moments: `PYTHONPATH=src:tests python -m fuzz.kills --kills 100`.

Either of `fsel select --force`, or with `--workflow` of a run of the smoke config, which is
continued by the same command until it is whole, and then begun anew until the kills are used up.
Whole results are compared with those of a run that nobody killed.
"""

import argparse
import hashlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd
from small_captures import write_ring

ROOT = Path(__file__).resolve().parents[2]
TIMED = re.compile(r"seconds|peak_bytes")  # columns that no two runs share
OTHERS = ("logs", "benchmarks", "data")  # data: what the captures are read from
LEFT = re.compile(r"\.[^.]+\.\d+\..*")  # an unfinished file


def main():
    """Kill, and say what was found: the exit code is 1 if anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m fuzz.kills")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workflow", action="store_true")
    parser.add_argument("--shortest", type=float, default=2.0, help="seconds, of --workflow")
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
    out = folder / "out"
    line = [sys.executable, "-m", "fsel", "select", str(folder / "ring"), "-k", "6", "--quiet"]
    line += ["--patience", "0", "-o", str(out)]
    subprocess.run(line, check=True)
    line.append("--force")
    started = time.monotonic()
    subprocess.run(line, check=True)
    whole, took = of_folder(out), time.monotonic() - started
    killed = differing = 0
    for _ in range(asked.kills):
        process = subprocess.Popen(line, stderr=subprocess.DEVNULL)
        time.sleep(rng.uniform(0.1, 0.9) * took)
        process.kill()
        killed += process.wait() == -signal.SIGKILL
        differing += of_folder(out) != whole
    subprocess.run(line, check=True)
    left = sorted(path.name for path in folder.iterdir() if path.name not in ("ring", "out"))
    print(f"{asked.kills} kills, {killed} in time; {differing} outputs missing or other; {left=}")
    return differing + len(left)


def of_workflow(folder, asked, rng):
    """How many continued runs failed, or have other results than a run that nobody killed."""
    work = folder / "work"
    started = time.monotonic()
    code, _ = continued(work, rng, asked, 0)
    whole = of_folder(work / "results")
    took = time.monotonic() - started
    print(f"undisturbed: code {code}, {len(whole)} files in {took:.0f} s", flush=True)
    killed = runs = wrong = 0
    while killed < asked.kills:
        shutil.rmtree(work)
        runs += 1
        code, kills = continued(work, rng, asked, asked.kills - killed)
        killed += kills
        found = of_folder(work / "results")
        other = sorted(n for n in whole.keys() | found.keys() if whole.get(n) != found.get(n))
        left = leftovers(work)
        wrong += bool(code or other or left)
        print(f"run {runs}: {code=}, {killed} kills so far, {other=}, {left=}", flush=True)
        if code:
            print((work / "said").read_text()[-3000:], flush=True)
    print(f"{killed} kills in {runs} runs, {wrong} wrong")
    return wrong


def continued(work, rng, asked, kills):
    """Run the smoke config in a folder, killed up to a number of times: exit code, kills done."""
    line = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
    line += ["--configfile", str(ROOT / "config" / "smoke.yaml"), "--cores", "1"]
    line += ["--workflow-profile", str(ROOT / "profiles" / "default"), *asked.targets]
    work.mkdir()
    for done in range(kills + 1):
        with (work / "said").open("w") as said:
            process = subprocess.Popen(
                line, cwd=work, stdout=said, stderr=said, start_new_session=True
            )
        try:
            seconds = rng.uniform(asked.shortest, asked.longest)
            return process.wait(seconds if done < kills else None), done
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # its jobs too
            process.wait()
            subprocess.run([*line, "--unlock"], cwd=work, capture_output=True, check=True)
    raise AssertionError("the last run has no limit")


def leftovers(work):
    """What killed processes left in the results."""
    return sorted(
        str(path.relative_to(work))
        for path in (work / "results").rglob("*")
        if LEFT.fullmatch(path.name) or path.suffix in (".journal", ".partial")
    )


def of_folder(folder):
    """Relative path -> digest of its content, what no two runs share aside."""
    found = {}
    for path in sorted(item for item in folder.rglob("*") if item.is_file()):
        name = path.relative_to(folder)
        if set(name.parts) & set(OTHERS) or path.name == "selection.json":
            continue
        if path.suffix == ".parquet":
            table = pd.read_parquet(path)
            kept = table[[column for column in table if not TIMED.search(column)]]
            content = kept.to_json().encode()
        elif path.suffix == ".pdf":  # PDF files tell when they were made
            content = b""
        else:
            content = path.read_bytes()
        found[str(name)] = hashlib.sha256(content).hexdigest()
    return found


if __name__ == "__main__":
    main()
