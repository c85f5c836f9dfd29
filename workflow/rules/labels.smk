"""Searched subsets of the training and validation scenes, and their trajectories.

Inputs: canonical captures of the training dataset.
Outputs: <results>/labels/{scene}/p{coverage}.parquet and splits.parquet,
<results>/trajectories.parquet.
"""


use rule stage as label with:
    input:
        **inputs.capture(inputs.DESCRIBED, f"<results>/{experiment.trained}/{{scene}}"),
        lib=experiment.library("label", experiment.labeller),
    output:
        labels=inputs.label_files(experiment, ["{scene}"]),
        splits="<results>/labels/{scene}/splits.parquet",
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


use rule stage as order with:
    input:
        **inputs.captures(inputs.labelled(experiment), inputs.BARE),
        splits=inputs.label_splits(experiment),
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
