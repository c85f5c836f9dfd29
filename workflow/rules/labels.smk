"""Searched subsets of the training and validation scenes, and their trajectories.

Inputs: canonical captures of the training dataset.
Outputs: <results>/labels/{scene}/{splits,features}.parquet and p{coverage}.parquet,
<results>/trajectories.parquet.
"""

LABELLED_SCENE = f"<results>/{experiment.trained}/{{scene}}"


use rule stage as split_labelled with:
    input:
        **inputs.capture(inputs.WITHOUT_POINTS, LABELLED_SCENE),
        lib=experiment.library("split_labelled"),
    output:
        splits="<results>/labels/{scene}/splits.parquet",
    log:
        "<results>/logs/split_labelled/{scene}.log",
    benchmark:
        "<results>/benchmarks/split_labelled/{scene}.jsonl"
    resources:
        **experiment.resources(Size(grows="capture")),
    params:
        coverages=experiment.config["coverages"],
        seed=experiment.training_seed,
    message:
        "Drawing the targets of {wildcards.scene} at every coverage level"


use rule features as features_labelled with:
    input:
        **inputs.capture([*inputs.WITHOUT_POINTS, "descriptors"], LABELLED_SCENE),
        splits=["<results>/labels/{scene}/splits.parquet"],
        lib=experiment.library("features"),
    output:
        tables=["<results>/labels/{scene}/features.parquet"],
    log:
        "<results>/logs/features_labelled/{scene}.log",
    benchmark:
        "<results>/benchmarks/features_labelled/{scene}.jsonl"
    message:
        "Computing the features of {wildcards.scene} at every coverage level"


use rule stage as label with:
    input:
        **inputs.capture(inputs.DESCRIBED, LABELLED_SCENE),
        **inputs.parts_before(experiment),
        splits="<results>/labels/{scene}/splits.parquet",
        lib=experiment.library("label", experiment.labeller),
    output:
        labels=inputs.label_files(experiment, ["{scene}"]),
    log:
        "<results>/logs/label/{scene}.log",
    benchmark:
        "<results>/benchmarks/label/{scene}.jsonl"
    resources:
        **experiment.resources(Size(4000, 120, "reconstruction"), experiment.labeller),
    params:
        coverages=experiment.config["coverages"],
        search=experiment.config["search"],
        reconstruction=experiment.labeller,
        fitness=experiment.fitness,
        seed=experiment.training_seed,
    message:
        "Searching for good subsets of {wildcards.scene}"


# all but the last of the jobs that label a scene, where there are several
use rule label as label_part with:
    input:
        **inputs.capture(inputs.DESCRIBED, LABELLED_SCENE),
        splits="<results>/labels/{scene}/splits.parquet",
        known=inputs.part_before,
        lib=experiment.library("label_part", experiment.labeller),
    output:
        evaluated=inputs.LABEL_PART,
    log:
        "<results>/logs/label_part/{scene}/{part}.log",
    benchmark:
        "<results>/benchmarks/label_part/{scene}/{part}.jsonl"
    wildcard_constraints:
        part=r"\d+",
    params:
        most=experiment.label_subsets,
    message:
        "Searching for good subsets of {wildcards.scene}, part {wildcards.part}"


use rule stage as order with:
    input:
        **inputs.captures(
            inputs.labelled(experiment), [*inputs.WITHOUT_POINTS, "descriptors"]
        ),
        splits=inputs.of_labelled(experiment, "splits"),
        features=inputs.of_labelled(experiment, "features"),
        labels=inputs.label_files(experiment),
        lib=experiment.library("order"),
    output:
        trajectories="<results>/trajectories.parquet",
    log:
        "<results>/logs/order.log",
    benchmark:
        "<results>/benchmarks/order.jsonl"
    resources:
        **experiment.resources(Size(grows="capture")),
    params:
        scenes=experiment.labelled,
        coverages=experiment.config["coverages"],
        kept=experiment.config["search"]["kept"],
    message:
        "Ordering the searched subsets"
