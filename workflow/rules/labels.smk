"""Searched subsets of the training and validation scenes, and their trajectories.

Inputs: canonical captures of the training dataset.
Outputs: <results>/labels/{scene}/{splits,features}.parquet and p{coverage}.parquet,
<results>/trajectories.parquet.
"""


rule split_labelled:
    input:
        frames=f"<results>/{TRAINED}/{{scene}}/frames.parquet",
        images=f"<results>/{TRAINED}/{{scene}}/images.npy",
        lib=library("split_labelled"),
    output:
        splits="<results>/labels/{scene}/splits.parquet",
    log:
        "<results>/logs/split_labelled/{scene}.log",
    benchmark:
        "<results>/benchmarks/split_labelled/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(1000),
        runtime=per_capture(10),
    params:
        coverages=config["coverages"],
        seed=lambda wildcards: training_seed(wildcards),
    message:
        "Drawing the targets of {wildcards.scene} at every coverage level"
    script:
        "../scripts/split_labelled.py"


use rule features as features_labelled with:
    input:
        splits=["<results>/labels/{scene}/splits.parquet"],
        frames=f"<results>/{TRAINED}/{{scene}}/frames.parquet",
        images=f"<results>/{TRAINED}/{{scene}}/images.npy",
        descriptors=f"<results>/{TRAINED}/{{scene}}/descriptors.parquet",
        lib=library("features"),
    output:
        tables=["<results>/labels/{scene}/features.parquet"],
    log:
        "<results>/logs/features_labelled/{scene}.log",
    benchmark:
        "<results>/benchmarks/features_labelled/{scene}.jsonl"
    message:
        "Computing the features of {wildcards.scene} at every coverage level"


rule label:
    input:
        frames=f"<results>/{TRAINED}/{{scene}}/frames.parquet",
        points=f"<results>/{TRAINED}/{{scene}}/points.parquet",
        images=f"<results>/{TRAINED}/{{scene}}/images.npy",
        descriptors=f"<results>/{TRAINED}/{{scene}}/descriptors.parquet",
        splits="<results>/labels/{scene}/splits.parquet",
        lib=library("label", LABELLED_BY["name"]),
    output:
        labels=expand(
            "<results>/labels/{{scene}}/p{coverage}.parquet",
            coverage=config["coverages"],
        ),
    log:
        "<results>/logs/label/{scene}.log",
    benchmark:
        "<results>/benchmarks/label/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=int(needs_gpu(LABELLED_BY)),
    params:
        coverages=config["coverages"],
        search=config["search"],
        reconstruction=LABELLED_BY,
        fitness=FITNESS,
        seed=lambda wildcards: training_seed(wildcards),
    message:
        "Searching for good subsets of {wildcards.scene}"
    script:
        "../scripts/label.py"


rule order:
    input:
        frames=collect(f"<results>/{TRAINED}/{{scene}}/frames.parquet", scene=LABELLED),
        images=collect(f"<results>/{TRAINED}/{{scene}}/images.npy", scene=LABELLED),
        descriptors=collect(
            f"<results>/{TRAINED}/{{scene}}/descriptors.parquet", scene=LABELLED
        ),
        splits=collect("<results>/labels/{scene}/splits.parquet", scene=LABELLED),
        features=collect("<results>/labels/{scene}/features.parquet", scene=LABELLED),
        labels=collect(
            "<results>/labels/{scene}/p{coverage}.parquet",
            scene=LABELLED,
            coverage=config["coverages"],
        ),
        lib=library("order"),
    output:
        trajectories="<results>/trajectories.parquet",
    log:
        "<results>/logs/order.log",
    benchmark:
        "<results>/benchmarks/order.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(1000),
        runtime=per_capture(10),
    params:
        scenes=LABELLED,
        coverages=config["coverages"],
        kept=config["search"]["kept"],
    message:
        "Ordering the searched subsets"
    script:
        "../scripts/order.py"
