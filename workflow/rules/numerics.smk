"""Whether the arithmetic can be trusted. Neither table is part of `rule all`.

Inputs: nothing (hard cases); or the first problem of every evaluation scene, trained scorers, and
the labels that they were trained on.
Outputs: <tables>/{stability,precision}.{tex,csv}.
"""


rule precision:
    input:
        frames=[f"<results>/{d}/{s}/frames.parquet" for d, s in evaluation_scenes()],
        points=[f"<results>/{d}/{s}/points.parquet" for d, s in evaluation_scenes()],
        images=[f"<results>/{d}/{s}/images.npy" for d, s in evaluation_scenes()],
        descriptors=[
            f"<results>/{d}/{s}/descriptors.parquet" for d, s in evaluation_scenes()
        ],
        splits=collect(
            "<results>/{problem}/split.parquet", problem=evaluation_problems(1)
        ),
        weights=[
            OURS[0],
            FSEL[0],
        ],
        trajectories="<results>/trajectories.parquet",
        trained_frames=collect(
            f"<results>/{TRAINED}/{{scene}}/frames.parquet", scene=LABELLED
        ),
        trained_descriptors=collect(
            f"<results>/{TRAINED}/{{scene}}/descriptors.parquet", scene=LABELLED
        ),
        trained_splits=collect(
            "<results>/labels/{scene}/splits.parquet", scene=LABELLED
        ),
        lib=library("precision"),
    output:
        table=report(
            "<tables>/precision.tex",
            caption="../report/precision.rst",
            category="Numerics",
            labels={"table": "Arithmetic", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/precision.csv",
            caption="../report/precision.rst",
            category="Numerics",
            labels={"table": "Arithmetic", "form": "numbers"},
        ),
    log:
        "<results>/logs/precision.log",
    benchmark:
        "<results>/benchmarks/precision.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(30),
        gpu=GPU,
    params:
        labels=[labels()[d] for d, _ in evaluation_scenes()],
        problems=evaluation_problems(1),
        scenes=list(LABELLED),
        training={"seed": 0}
        | {key: config["training"][key] for key in ("epochs", "learning_rate")},
        k=config["search"]["k"],
        reconstruction=config["reconstruction"],
        facts=facts(),
    message:
        "Comparing precisions"
    script:
        "../scripts/precision.py"
