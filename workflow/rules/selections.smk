"""Captures for trainers of scenes that are selected from; nothing is trained or evaluated.

Inputs: folders of captures on disk, as of `ingest`.
Outputs: <results>/selections/{dataset}/{part}/{scene}/, <results>/selections.csv.
"""


use rule stage as curate with:
    input:
        sources=lambda wildcards: [
            kept_here(experiment.datasets.raw_capture)(of)
            for of in experiment.curated_by(wildcards)
        ],
    output:
        folder=directory("<results>/selections/{dataset}/{part}"),
    log:
        "<results>/logs/curate/{dataset}/{part}.log",
    benchmark:
        "<results>/benchmarks/curate/{dataset}/{part}.jsonl"
    wildcard_constraints:
        part=r"\d+",
    resources:
        **experiment.resources(2000)
        | {
            # two minutes a scene, or as long as `ingest` takes
            "runtime": lambda wildcards, attempt: max(
                experiment.ingest_minutes(wildcards, attempt),
                2 * attempt * len(experiment.curated_by(wildcards)),
            ),
            "gpu": experiment.ingest_gpus,
        },
    params:
        lib=experiment.library("curate"),
        scenes=lambda wildcards: {
            of.scene: experiment.datasets.reading(of)
            | {"seed": experiment.scene_seed(of, "select")}
            for of in experiment.curated_by(wildcards)
        },
        request=experiment.config["selections"]["request"],
        form=experiment.config["selections"]["form"],
    message:
        "Selecting frames of {wildcards.dataset}, part {wildcards.part}"


use rule stage as selections with:
    input:
        folders=lambda wildcards: [
            f"<results>/selections/{dataset}/{part}"
            for dataset, part in scenes.selected(experiment)
        ],
    output:
        table="<results>/selections.csv",
    log:
        "<results>/logs/selections.log",
    params:
        lib=experiment.library("selections"),
    message:
        "Listing the selections"
