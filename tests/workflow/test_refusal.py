"""What stands last in a terminal when jobs failed."""

from fsel.workflow.refusal import failures

RUN = """Error in rule ingest:
    log: {folder}/a.log (check log file(s) for error details)
Error in rule split:
    log: {folder}/b.log (check log file(s) for error details)
Error in rule ingest:
    log: {folder}/a.log (check log file(s) for error details)
Error in rule label:
    log: {folder}/c.log (check log file(s) for error details)
    log: {folder}/d.log (check log file(s) for error details)
    log: {folder}/gone.log (check log file(s) for error details)
"""


def test_each_failed_job_says_its_last_line_once(tmp_path):
    folder = tmp_path / "a run"
    folder.mkdir()
    logs = {
        "run": RUN.format(folder=folder),
        "a": "Traceback (most recent call last):\nValueError: room: 80 frames\n",
        "b": "2026-11-23 12:53:52,942 ERROR fsel: b.parquet: is damaged\n",
        "d": "fsel.outcome.Unfinished: frames [3, 5]\nin fit\nCUDA error: assert\n",
        "c": "2026-11-23 12:53:52,942 INFO fsel: done in 3.0 s, 2.0 s of the processor\n",
    }
    for name, text in logs.items():
        (folder / f"{name}.log").write_text(text)
    assert failures([str(folder / "run.log")]).splitlines() == [
        "fsel: room: 80 frames",
        f"  ({folder}/a.log)",
        "fsel: b.parquet: is damaged",
        f"  ({folder}/b.log)",
        "fsel: frames [3, 5]: CUDA error: assert",
        f"  ({folder}/d.log)",
    ]
