"""What Snakemake prints of jobs: a line as each starts and ends, and all of an error."""

import logging
import re
from io import StringIO

import pytest
from snakemake.logging import ColorizingTextHandler, DefaultFilter, DefaultFormatter
from snakemake.settings.types import Quietness

from fsel.workflow.log import one_line_a_job

JOB = {"jobid": 7, "rule_name": "select", "rule_msg": "Selecting", "reason": "x" * 5000}
JOB |= {"input": ["in.npy"], "output": [], "log": ["select.log"], "wildcards": {"scene": "a"}}
JOB |= {"conda_env": None, "shellcmd": None, "aux": {}, "job_id": 7, "done": 3, "total": 40}
EVENTS = ("job_started", "job_info", "job_finished", "progress", "job_error")


def printed(quiet=()):
    """Lines that are printed of a job that starts and ends, and of its error."""
    stream, log = StringIO(), logging.Logger("snakemake")
    shown = DefaultFilter(set(quiet), False, False, False, False)
    log.addHandler(ColorizingTextHandler(True, stream, DefaultFormatter(set(quiet)), shown))
    one_line_a_job(log)
    log.info("Select jobs to execute...")
    for event in EVENTS:
        log.info("said", extra=JOB | {"event": event})
    return stream.getvalue().splitlines()


def test_a_job_has_a_line_as_it_starts_and_as_it_ends_and_errors_are_whole():
    started, ended, *error = printed()
    assert started.split() == ["7", "select", "a"]
    assert re.findall(r"\d+", ended) == ["7", "3", "40"]
    assert any("select.log" in line for line in error)
    assert max(map(len, printed())) < 200


@pytest.mark.parametrize(
    ("quiet", "left", "gone"), [("progress", "a", "40"), ("rules", "40", "select")]
)
def test_what_is_to_be_quiet_stays_so(quiet, left, gone):
    lines = printed([Quietness.parse_choice(quiet)])
    assert left in lines[0]
    assert not any(gone in line for line in lines)
