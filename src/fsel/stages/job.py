"""What every script of the workflow shares: its log, its threads, its config digest.

The only module that touches the `snakemake` object.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2

from fsel.files import digest

POLL = 1.0  # seconds between looks for the parent process

logger = logging.getLogger("fsel")


@contextmanager
def job(snakemake) -> Iterator[str]:
    """Run a script's body as a job: logged to `snakemake.log[0]`, within its threads.

    Args:
        snakemake: the object that Snakemake hands to a script.

    Yields:
        The digest of the job's parameters, which its tables carry.
    """
    _end_with_parent()
    path = Path(snakemake.log[0])
    path.parent.mkdir(parents=True, exist_ok=True)
    handler = logging.FileHandler(path, mode="w")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    root = logging.getLogger()
    root.addHandler(handler)
    root.setLevel(logging.INFO)
    logging.captureWarnings(True)
    cv2.setNumThreads(snakemake.threads)
    started = time.perf_counter()
    try:
        yield digest(dict(snakemake.params.items()))
        logger.info("done in %.1f s", time.perf_counter() - started)
    except BaseException:
        logger.exception("failed")
        raise
    finally:
        root.removeHandler(handler)
        handler.close()


def named(problems: Iterable[str], paths: Iterable[str]) -> list[dict[str, str]]:
    """One mapping a file of a problem: dataset, scene, draw, path.

    Args:
        problems: `dataset/scene/draw0` of each file.
        paths: of the files.
    """
    keys = ("dataset", "scene", "draw")
    return [
        dict(zip(keys, problem.split("/"), strict=True), path=path)
        for problem, path in zip(problems, paths, strict=True)
    ]


def _end_with_parent() -> None:
    """End this process soon after Snakemake's own: a killed run must leave no job behind.

    A job that outlived a killed run would write its output beside the run that replaces it.
    """
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(POLL)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
