"""Snakemake's log on a terminal: a line for each job as it starts, and one as it ends."""

from __future__ import annotations

import logging

UNSAID = ("Select jobs to execute...", "Job rate limit reached, waiting for free slots.")


class JobLines(logging.Handler):
    """What another handler prints, with one line for a job's start and one for its end.

    Snakemake's own file has the rest: when, from which files, why.
    """

    def __init__(self, usual: logging.Handler) -> None:
        super().__init__()
        self._usual = usual
        self._ended: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record as one line, or as the other handler does, or keep it for the next."""
        event, known = str(getattr(record, "event", "")), record.__dict__
        if not self._usual.filter(record) or event == "job_started" or record.msg in UNSAID:
            return
        if event == "job_finished":
            self._ended.append(str(known["job_id"]))
            return
        text = None
        if event == "progress":
            text = f"{', '.join(self._ended)} done, {known['done']}/{known['total']}"
            self._ended = []
        elif event == "job_info":
            of = "/".join(filter(None, map(str, known["wildcards"].values())))
            text = f"{known['jobid']} {known['rule_name']} {of}".rstrip()
        level = {"levelno": logging.INFO, "levelname": "INFO"}
        self._usual.handle(record if text is None else logging.makeLogRecord({"msg": text} | level))


def one_line_a_job(log: logging.Logger) -> None:
    """Shorten what Snakemake's logger prints; its files keep everything."""
    for handler in list(log.handlers):
        if isinstance(handler, logging.StreamHandler) and not hasattr(handler, "baseFilename"):
            log.removeHandler(handler)
            log.addHandler(JobLines(handler))
