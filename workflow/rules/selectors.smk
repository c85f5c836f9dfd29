"""The learned selectors.

Inputs: trajectories, and canonical captures of all train scenes.
Outputs: <results>/selector/{fold}seed{seed}.safetensors (`less_is_more`), and those of its variants
in folders beside it, each with a log of its training beside it.
"""


use rule stage as train with:
    input:
        **inputs.captures(inputs.labelled(experiment), inputs.DESCRIBED),
        trajectories="<results>/{fold}trajectories.parquet",
        splits=inputs.of_labelled(experiment, "splits"),
        features=inputs.of_labelled(experiment, "features"),
    output:
        # all seeds in one job: they share the trajectories' inputs, and the import of torch
        **inputs.scorer_files(experiment, "less_is_more", "{fold}"),
    log:
        "<results>/logs/{fold}train.log",
    benchmark:
        "<results>/benchmarks/{fold}train.jsonl"
    resources:
        **experiment.resources(4000, 60),
    params:
        **inputs.training(experiment, "less_is_more"),
        lib=experiment.library("train"),
    message:
        "Training {params.policy}"


use rule train as train_no_appearance with:
    output:
        **inputs.scorer_files(experiment, "less_is_more_no_appearance", "{fold}"),
    log:
        "<results>/logs/{fold}train_no_appearance.log",
    benchmark:
        "<results>/benchmarks/{fold}train_no_appearance.jsonl"
    params:
        **inputs.training(experiment, "less_is_more_no_appearance"),


use rule train as train_geometry with:
    output:
        **inputs.scorer_files(experiment, "less_is_more_geometry", "{fold}"),
    log:
        "<results>/logs/{fold}train_geometry.log",
    benchmark:
        "<results>/benchmarks/{fold}train_geometry.jsonl"
    params:
        **inputs.training(experiment, "less_is_more_geometry"),
