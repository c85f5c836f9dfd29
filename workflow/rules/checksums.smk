"""Damaged artefacts are refused before a job starts: Snakemake removes outputs of jobs that fail."""

from fsel.utils.checksums import damages, remade


def check_artefacts(dag):
    """Refuse inputs of the jobs ahead that are not what was written, unless they are made anew."""
    jobs = list(dag.needrun_jobs())
    made = {path for job in jobs for path in job.output}
    found = damages({path for job in jobs for path in job.input} - made)
    if found:
        raise WorkflowError(
            "\n".join([*found.values(), remade(found, "the options of this run")])
        )
