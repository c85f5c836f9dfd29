"""Searched subsets of the training and validation scenes, and their trajectories.

Inputs: canonical captures of the training dataset.
Outputs: <results>/labels/{scene}/p{coverage}.parquet and splits.parquet,
<results>/trajectories.parquet.
"""


rule label:
    input:
        frames=f"<results>/{TRAINED}/{{scene}}/frames.parquet",
        points=f"<results>/{TRAINED}/{{scene}}/points.parquet",
        images=f"<results>/{TRAINED}/{{scene}}/images.npy",
        descriptors=f"<results>/{TRAINED}/{{scene}}/descriptors.parquet",
        lib=library("label", LABELLED_BY["name"]),
    output:
        labels=expand(
            "<results>/labels/{{scene}}/p{coverage}.parquet",
            coverage=config["coverages"],
        ),
        splits="<results>/labels/{scene}/splits.parquet",
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
        splits=collect("<results>/labels/{scene}/splits.parquet", scene=LABELLED),
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
