"""Searched subsets of the training and validation scenes, and their trajectories.

Inputs: canonical captures of the training dataset.
Outputs: <results>/labels/{scene}/{splits,features}.parquet and p{coverage}.parquet,
<results>/{fold}trajectories.parquet.
"""

LABELLED_SCENE = f"<results>/{experiment.trained}/{{scene}}"


use rule stage as split_labelled with:
    input:
        **inputs.capture(folder=LABELLED_SCENE),
    output:
        splits="<results>/labels/{scene}/splits.parquet",
    log:
        "<results>/logs/split_labelled/{scene}.log",
    benchmark:
        "<results>/benchmarks/split_labelled/{scene}.jsonl"
    resources:
        **experiment.resources(grows="capture"),
    params:
        lib=experiment.library("split_labelled"),
        coverages=lambda wildcards: experiment.coverages[wildcards.scene],
        seed=experiment.training_seed,
    message:
        "Drawing the targets of {wildcards.scene} at every coverage level"


use rule features as features_labelled with:
    input:
        **inputs.capture(inputs.DESCRIBED, LABELLED_SCENE),
        splits=["<results>/labels/{scene}/splits.parquet"],
    output:
        tables=["<results>/labels/{scene}/features.parquet"],
    log:
        "<results>/logs/features_labelled/{scene}.log",
    benchmark:
        "<results>/benchmarks/features_labelled/{scene}.jsonl"
    params:
        lib=experiment.library("features"),
    message:
        "Computing the features of {wildcards.scene} at every coverage level"


use rule stage as label with:
    input:
        **inputs.capture(inputs.DESCRIBED, LABELLED_SCENE),
        splits="<results>/labels/{scene}/splits.parquet",
    output:
        labels=inputs.LABELS,
    log:
        "<results>/logs/label/{scene}/p{coverage}.log",
    benchmark:
        "<results>/benchmarks/label/{scene}/p{coverage}.jsonl"
    resources:
        **experiment.resources(4000, 60, "reconstruction", experiment.labeller),
    params:
        lib=experiment.library("label", experiment.labeller),
        coverage=lambda wildcards: int(wildcards.coverage),
        search=experiment.config["search"],
        reconstruction=experiment.labeller,
        fitness=experiment.fitness,
        seed=experiment.training_seed,
    message:
        "Searching for good subsets of {wildcards.scene} at coverage {wildcards.coverage} %"


use rule stage as order with:
    input:
        **inputs.captures(inputs.labelled(experiment), inputs.DESCRIBED),
        splits=inputs.of_labelled(experiment, "splits"),
        features=inputs.of_labelled(experiment, "features"),
        labels=inputs.label_files(experiment),
    output:
        trajectories="<results>/{fold}trajectories.parquet",
    log:
        "<results>/logs/{fold}order.log",
    benchmark:
        "<results>/benchmarks/{fold}order.jsonl"
    resources:
        **experiment.resources(grows="capture"),
    params:
        lib=experiment.library("order"),
        scenes=lambda wildcards: experiment.roles(wildcards.fold),
        coverages=experiment.coverages,
        kept=experiment.config["search"]["kept"],
    message:
        "Ordering the searched subsets"
