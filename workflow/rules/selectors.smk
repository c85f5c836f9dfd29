"""The learned selectors.

Inputs: trajectories, and canonical captures of all train scenes.
Outputs: <results>/selector/seed{seed}.safetensors (`less_is_more`),
<results>/selector/no_appearance/seed{seed}.safetensors, <results>/selector/fsel/seed{seed}.json,
each with a log of its training beside it.
"""


rule train:
    input:
        trajectories="<results>/trajectories.parquet",
        frames=collect(f"<results>/{TRAINED}/{{scene}}/frames.parquet", scene=LABELLED),
        descriptors=collect(
            f"<results>/{TRAINED}/{{scene}}/descriptors.parquet", scene=LABELLED
        ),
        splits=collect("<results>/labels/{scene}/splits.parquet", scene=LABELLED),
        features=collect("<results>/labels/{scene}/features.parquet", scene=LABELLED),
        lib=library("train"),
    output:
        # all seeds in one job: they share the trajectories' inputs, and the import of torch
        weights=collect("<results>/selector/seed{seed}.safetensors", seed=SEEDS),
        logs=collect("<results>/selector/seed{seed}.parquet", seed=SEEDS),
    log:
        "<results>/logs/train/less_is_more.log",
    benchmark:
        "<results>/benchmarks/train/less_is_more.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(4000),
        runtime=growing(60),
    params:
        policy="less_is_more",
        scenes=list(LABELLED),
        epochs=config["training"]["epochs"],
        learning_rate=config["training"]["learning_rate"],
    message:
        "Training {params.policy}"
    script:
        "../scripts/train.py"


use rule train as train_no_appearance with:
    output:
        weights=collect(
            "<results>/selector/no_appearance/seed{seed}.safetensors", seed=SEEDS
        ),
        logs=collect("<results>/selector/no_appearance/seed{seed}.parquet", seed=SEEDS),
    log:
        "<results>/logs/train/less_is_more_no_appearance.log",
    benchmark:
        "<results>/benchmarks/train/less_is_more_no_appearance.jsonl"
    params:
        policy="less_is_more_no_appearance",
        scenes=list(LABELLED),
        epochs=config["training"]["epochs"],
        learning_rate=config["training"]["learning_rate"],


rule refine:
    input:
        frames=collect("<results>/{scene}/frames.parquet", scene=PRACTISED),
        points=collect("<results>/{scene}/points.parquet", scene=PRACTISED),
        images=collect("<results>/{scene}/images.npy", scene=PRACTISED),
        descriptors=collect("<results>/{scene}/descriptors.parquet", scene=PRACTISED),
        lib=library("refine"),
    output:
        weights="<results>/selector/fsel/seed{seed}.json",
        log="<results>/selector/fsel/seed{seed}.parquet",
    log:
        "<results>/logs/refine/seed{seed}.log",
    benchmark:
        "<results>/benchmarks/refine/seed{seed}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(8000),
        runtime=per_reconstruction(240),
        gpu=GPU,
    params:
        scenes=PRACTISED,
        seed=lambda wildcards: int(wildcards.seed),
        settings=config["refinement"] | {"seed": config["seed"]},
        reconstruction=config["reconstruction"],
    message:
        "Refining fsel against reconstruction, seed {wildcards.seed}"
    script:
        "../scripts/refine.py"
