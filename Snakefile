from snakemake.utils import min_version

min_version("9.19.0")


pathvars:
    tables="<results>/tables",
    figures="<results>/figures",
    downloads="downloads",


# a config file given on the command line stands alone: merged, its datasets would join these
if "datasets" not in config:

    configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


include: "workflow/rules/sources.smk"
include: "workflow/rules/common.smk"
include: "workflow/rules/cases.smk"
include: "workflow/rules/downloads.smk"
include: "workflow/rules/captures.smk"
include: "workflow/rules/labels.smk"
include: "workflow/rules/selectors.smk"
include: "workflow/rules/sweep.smk"
include: "workflow/rules/speed.smk"
include: "workflow/rules/budget.smk"
include: "workflow/rules/numerics.smk"
include: "workflow/rules/trials.smk"
include: "workflow/rules/objects.smk"
include: "workflow/rules/poses.smk"
include: "workflow/rules/paper.smk"


rule all:
    default_target: True
    input:
        "<tables>/ksweep.tex",
        "<figures>/heatmap.pdf",
        features=collect(
            "<results>/{problem}/features.parquet", problem=problems(config["draws"])
        ),
    localrule: True
