"""What only a cluster asks for: resources that grow, and jobs that a killed run left behind."""

import sys

DECLARED_FRAMES = 10_000  # of a capture, up to which what a rule states suffices
DECLARED_SIDE = 128  # pixels of a reconstruction's long side, likewise


def growing(amount):
    """A resource of which a job that failed gets twice as much, then three times."""
    return lambda wildcards, attempt: amount * attempt


def per_capture(amount):
    """A growing resource that follows the frames of the largest capture among the inputs."""
    return lambda wildcards, input, attempt: int(amount * attempt * captured(input))


def per_reconstruction(amount):
    """A growing resource that follows frames, and the pixels of the largest reconstruction here:
    external programs take memory of their own."""
    own = [section for section in JUDGES.values() if section["name"] != "external"]
    side = max([section["long_side"] for section in own], default=DECLARED_SIDE)
    pixels = max(1, (side / DECLARED_SIDE) ** 2)
    return lambda wildcards, input, attempt: int(
        amount * attempt * captured(input) * pixels
    )


def captured(files):
    """Frames of the largest capture that is there, over those that a rule's numbers are for."""
    from fsel.utils.files import mapped_array

    there = [path for path in files if Path(path).name == "images.npy"]
    frames = [len(mapped_array(f)) for f in there if os.path.exists(f)]
    return max([1, *(count / DECLARED_FRAMES for count in frames)])


def start_on_cluster():
    """Before Slurm gets jobs: refuse a run without a lock, end the jobs of a run that was killed."""
    if not workflow.is_main_process or workflow.executor_plugin.name != "slurm":
        return
    from fsel.workflow.slurm import end_earlier_jobs

    if not workflow.execution_settings.lock:
        refuse(
            "Slurm, but no lock on the folder: two runs would write the same files",
            "`--workflow-profile profiles/slurm` replaces the default profile, "
            "`--profile` only adds to it",
        )
    if len(list(Path(".snakemake/locks").glob("*.output.lock"))) > 1:
        refuse(
            "another run holds a lock in this folder, and its jobs cannot be told from a dead run's",
            "wait for it; if it was killed, the same command with --unlock takes the locks away",
        )
    try:
        ended = end_earlier_jobs(
            workflow.executor_settings.jobname_prefix or "", Path.cwd()
        )
    except ValueError as error:
        raise WorkflowError(str(error))
    if ended:
        print(f"Cancelled jobs of an earlier run: {' '.join(ended)}", file=sys.stderr)
