"""Snakemake's log on a terminal: a line for each job as it starts, and one as it ends."""

from __future__ import annotations

import logging

UNSAID = ("Select jobs to execute...", "Job rate limit reached, waiting for free slots.")


class JobLines(logging.Handler):
    """What another handler prints, but for jobs, which get one line as they start and as they end.

    Snakemake's own file has the rest: when, from which files, why.
    """

    def __init__(self, usual: logging.Handler) -> None:
        super().__init__()
        self._usual = usual
        self._ended: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record as one line, or as the other handler does, or keep it for the next."""
        event = str(getattr(record, "event", ""))
        if not self._usual.filter(record) or event == "job_started" or record.msg in UNSAID:
            return
        known = record.__dict__
        if event == "job_finished":
            self._ended.append(str(known["job_id"]))
        elif event == "progress":
            self._say(f"{', '.join(self._ended)} done, {known['done']} of {known['total']}")
            self._ended = []
        elif event == "job_info":
            of = "/".join(map(str, known["wildcards"].values()))
            self._say(f"{known['jobid']} {known['rule_name']} {of}".rstrip())
        else:
            self._usual.handle(record)

    def _say(self, text: str) -> None:
        level = {"levelno": logging.INFO, "levelname": "INFO"}
        self._usual.handle(logging.makeLogRecord({"msg": text, **level}))


def one_line_a_job(log: logging.Logger) -> None:
    """Shorten what Snakemake's logger prints; its files keep everything."""
    for handler in list(log.handlers):
        if isinstance(handler, logging.StreamHandler) and not hasattr(handler, "baseFilename"):
            log.removeHandler(handler)
            log.addHandler(JobLines(handler))
