"""The image that jobs run in with `--software-deployment-method apptainer`, and only then."""

from snakemake.settings.types import DeploymentMethod

IMAGE = Path(workflow.basedir, "workflow", "envs", "fsel.sif")


container: str(IMAGE)


# the settings are not there where the rules are only read
if workflow.deployment_settings and (
    DeploymentMethod.APPTAINER in workflow.deployment_settings.deployment_method
):
    if not IMAGE.exists():
        raise WorkflowError(
            f"no {IMAGE}, the image for --software-deployment-method apptainer\n"
            f"Hint: apptainer build {IMAGE} {IMAGE.with_suffix('.def')}"
        )
    # the image holds what the library needs; the library is this one
    os.environ.update(PYTHONPATH=str(Path(workflow.basedir, "src")))
