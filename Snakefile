import sys
from functools import partial
from pathlib import Path

from snakemake.settings.types import DeploymentMethod
from snakemake.utils import min_version

min_version("9.19.0")
sys.path.insert(0, str(Path(workflow.basedir, "src")))

from fsel.workflow import cases, inputs, requirements, scenes
from fsel.workflow.experiment import Experiment, gpus_of
from fsel.workflow.log import one_line_a_job
from fsel.workflow.machine import prepare
from fsel.workflow.paper import Paper

prepare(Path(workflow.basedir, "src"), verbose=workflow.is_main_process)


pathvars:
    tables="<results>/tables",
    figures="<results>/figures",
    downloads="downloads",


# a config file given on the command line stands alone: merged, its datasets would join these
if "datasets" not in config:

    configfile: "config/config.yaml"


results_storage = workflow.storage_settings
stored = bool(results_storage and results_storage.default_storage_provider)
if stored and workflow.is_main_process:
    check_storage = partial(
        requirements.check_storage,
        workflow.storage_registry.default_storage_provider,
        results_storage.default_storage_prefix or "",
    )
    check_storage()
experiment = Experiment.load(
    config, Path(workflow.basedir), asks=workflow.is_main_process
).with_obtainable_metrics(
    ask=workflow.is_main_process,
    stored=stored,
)
paper = Paper(experiment, asks=workflow.is_main_process)
if workflow.is_main_process:
    paper.check(workflow.configfiles)
experiment.check()
image = config["container"] or str(
    Path(workflow.basedir, "workflow", "envs", "fsel.sif")
)
# the settings are not there where the rules are only read
if workflow.deployment_settings and (
    DeploymentMethod.APPTAINER in workflow.deployment_settings.deployment_method
):

    # only here: Snakemake takes no path with a space for an image
    container: image


report: "workflow/report/workflow.rst"


# `reconstructor` is the folder of a further one with its slash, and empty for the first
wildcard_constraints:
    dataset=experiment.datasets.names(),
    scene=r"[^/]+",
    draw=r"\d+",
    seed=r"\d+",
    reconstructor=experiment.folders,


# the experiment, stage by stage
include: "workflow/rules/common.smk"
include: "workflow/rules/stage.smk"
include: "workflow/rules/captures.smk"


if experiment.labelled:

    include: "workflow/rules/labels.smk"
    include: "workflow/rules/selectors.smk"


include: "workflow/rules/evaluation.smk"
# on request: other tables and figures by their paths, or all of the paper's by `paper`
include: "workflow/rules/paper.smk"
include: "workflow/rules/studies.smk"
include: "workflow/rules/selections.smk"


onstart:
    if workflow.is_main_process:
        one_line_a_job(logger)
        experiment.fetch_weights()
        if stored:
            check_storage(write=True)


rule all:
    default_target: True
    input:
        expand(
            "<tables>/{folder}ksweep.tex",
            folder=["", *experiment.extra_reconstructors],
        ),
        expand(
            "<figures>/{folder}heatmap.pdf",
            folder=["", *experiment.extra_reconstructors],
        ),
    localrule: True
