from snakemake.utils import min_version

min_version("9.19.0")

# images of containers often set it: every job would compile pandas anew, a second each
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


pathvars:
    tables="<results>/tables",
    figures="<results>/figures",
    downloads="downloads",


# a config file given on the command line stands alone: merged, its datasets would join these
if "datasets" not in config:

    configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


# the config, checked, and what all rules use
include: "workflow/rules/sources.smk"
include: "workflow/rules/lacking.smk"
include: "workflow/rules/common.smk"
include: "workflow/rules/cluster.smk"
include: "workflow/rules/container.smk"
include: "workflow/rules/library.smk"
include: "workflow/rules/checksums.smk"
include: "workflow/rules/cases.smk"
include: "workflow/rules/judging.smk"
include: "workflow/rules/picturing.smk"
include: "workflow/rules/needs.smk"
# the experiment, stage by stage: captures, labels, selectors, the budget sweep
include: "workflow/rules/downloads.smk"
include: "workflow/rules/captures.smk"
include: "workflow/rules/labels.smk"
include: "workflow/rules/selectors.smk"
include: "workflow/rules/sweep.smk"
# when asked for: other tables and figures, by name or all of the paper's by `paper`
include: "workflow/rules/speed.smk"
include: "workflow/rules/budget.smk"
include: "workflow/rules/swaps.smk"
include: "workflow/rules/numerics.smk"
include: "workflow/rules/trials.smk"
include: "workflow/rules/objects.smk"
include: "workflow/rules/poses.smk"
include: "workflow/rules/pose_sources.smk"
include: "workflow/rules/freedom.smk"
include: "workflow/rules/paper.smk"
include: "workflow/rules/pictures.smk"
include: "workflow/rules/judges.smk"
include: "workflow/rules/judged_paper.smk"
include: "workflow/rules/transfer.smk"
include: "workflow/rules/untold.smk"


# one handler for all: of several, only the last would run
onstart:
    start_on_cluster()
    check_artefacts(workflow.dag)


rule all:
    default_target: True
    input:
        # all of it, or nothing: `paper` goes without datasets that are not there
        complete,
        "<tables>/ksweep.tex",
        "<figures>/heatmap.pdf",
        collect("<tables>/{judge}/ksweep.tex", judge=FURTHER),
        collect("<figures>/{judge}/heatmap.pdf", judge=FURTHER),
    localrule: True
