"""What Snakemake prints of jobs: a line as each starts and ends, and all of an error."""

import logging
from io import StringIO

import pytest
from snakemake.logging import ColorizingTextHandler, DefaultFilter, DefaultFormatter
from snakemake.settings.types import Quietness
from snakemake_interface_logger_plugins.common import LogEvent

from fsel.workflow.log import one_line_a_job

JOB = {"jobid": 7, "rule_name": "select", "rule_msg": "Selecting", "reason": "x" * 5000}


def printed(quiet=()):
    """What is printed of a job that ends, of one that fails, and between."""
    stream, log = StringIO(), logging.Logger("snakemake")
    shown = DefaultFilter(set(quiet), False, False, False, False)
    log.addHandler(ColorizingTextHandler(True, stream, DefaultFormatter(set(quiet)), shown))
    one_line_a_job(log)
    log.info("Select jobs to execute...")
    log.info("Execute 1 jobs...", extra={"event": LogEvent.JOB_STARTED})
    more = {"event": LogEvent.JOB_INFO, "wildcards": {"dataset": "dl3dv", "scene": "a"}}
    log.info("", extra=JOB | more)
    log.info("Finished jobid: 7", extra={"event": LogEvent.JOB_FINISHED, "job_id": 7})
    log.info(None, extra={"event": LogEvent.PROGRESS, "done": 3, "total": 40})
    files = {"input": ["in.npy"], "output": [], "log": ["select.log"]}
    failed = JOB | files | {"conda_env": None, "shellcmd": None, "aux": {}, "indent": False}
    log.error("failed", extra={"event": LogEvent.JOB_ERROR} | failed | {"rule_msg": "Selecting"})
    return stream.getvalue().splitlines()


def test_a_job_has_a_line_as_it_starts_and_as_it_ends_and_errors_are_whole():
    started, ended, *error = printed()
    assert started.split() == ["7", "select", "dl3dv/a"]
    assert {"7", "3", "40"} <= set(ended.replace(",", "").split())
    assert any("select.log" in line for line in error)
    assert max(map(len, printed())) < 200


@pytest.mark.parametrize(
    ("quiet", "left", "gone"), [("progress", "dl3dv", "40"), ("rules", "40", "dl3dv")]
)
def test_what_is_to_be_quiet_stays_so(quiet, left, gone):
    lines = printed([Quietness.parse_choice(quiet)])
    assert left in lines[0]
    assert not any(gone in line for line in lines)
