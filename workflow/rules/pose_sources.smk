"""Ours with two sources of poses for the same images. Part of `paper` alone.

Inputs: scenes on disk with a second source of poses, trained selectors.
Outputs: <results>/{dataset}/{scene}/sources/{given,estimated}/ (canonical captures),
<results>/{dataset}/{scene}/sources/{picks,evaluation}.parquet, <tables>/pose_sources.{tex,csv}.
"""


rule pair_poses:
    input:
        source=raw_capture,
        lib=library("pair_poses"),
    output:
        given_frames="<results>/{dataset}/{scene}/sources/given/frames.parquet",
        given_points="<results>/{dataset}/{scene}/sources/given/points.parquet",
        given_images="<results>/{dataset}/{scene}/sources/given/images.npy",
        estimated_frames="<results>/{dataset}/{scene}/sources/estimated/frames.parquet",
        estimated_points="<results>/{dataset}/{scene}/sources/estimated/points.parquet",
        estimated_images="<results>/{dataset}/{scene}/sources/estimated/images.npy",
    log:
        "<results>/logs/pair_poses/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/pair_poses/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(4000),
        runtime=growing(240),
    params:
        model=config["pose_sources"]["model"],
        long_side=config["long_side"],
        at_least=frames_needed("evaluation"),
        reading=lambda wildcards: reading(wildcards.dataset, wildcards.scene),
    message:
        "Reading two sources of poses of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/pair_poses.py"


use rule describe as describe_paired with:
    input:
        frames="<results>/{dataset}/{scene}/sources/given/frames.parquet",
        images="<results>/{dataset}/{scene}/sources/given/images.npy",
        lib=library("describe"),
    output:
        descriptors="<results>/{dataset}/{scene}/sources/given/descriptors.parquet",
    log:
        "<results>/logs/describe_paired/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/describe_paired/{dataset}/{scene}.jsonl"


use rule select_estimated as select_paired with:
    input:
        given_frames="<results>/{dataset}/{scene}/sources/given/frames.parquet",
        given_points="<results>/{dataset}/{scene}/sources/given/points.parquet",
        given_images="<results>/{dataset}/{scene}/sources/given/images.npy",
        estimated_frames="<results>/{dataset}/{scene}/sources/estimated/frames.parquet",
        estimated_points="<results>/{dataset}/{scene}/sources/estimated/points.parquet",
        estimated_images="<results>/{dataset}/{scene}/sources/estimated/images.npy",
        given_descriptors="<results>/{dataset}/{scene}/sources/given/descriptors.parquet",
        weights=SCORERS,
        lib=library("select_estimated"),
    output:
        picks="<results>/{dataset}/{scene}/sources/picks.parquet",
    log:
        "<results>/logs/select_paired/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_paired/{dataset}/{scene}.jsonl"
    params:
        draws=config["draws"],
        budgets=config["budgets"],
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "sources"),
        split_seed=lambda wildcards: scene_seed(wildcards, "split"),
    message:
        "Selecting with two sources of poses of {wildcards.dataset}/{wildcards.scene}"


use rule evaluate_estimated as evaluate_paired with:
    input:
        given_frames="<results>/{dataset}/{scene}/sources/given/frames.parquet",
        given_points="<results>/{dataset}/{scene}/sources/given/points.parquet",
        given_images="<results>/{dataset}/{scene}/sources/given/images.npy",
        estimated_frames="<results>/{dataset}/{scene}/sources/estimated/frames.parquet",
        estimated_points="<results>/{dataset}/{scene}/sources/estimated/points.parquet",
        estimated_images="<results>/{dataset}/{scene}/sources/estimated/images.npy",
        picks="<results>/{dataset}/{scene}/sources/picks.parquet",
        lib=library("evaluate_estimated"),
    output:
        evaluation="<results>/{dataset}/{scene}/sources/evaluation.parquet",
    log:
        "<results>/logs/evaluate_paired/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_paired/{dataset}/{scene}.jsonl"
    params:
        targets=config["targets"],
        split_seed=lambda wildcards: scene_seed(wildcards, "split"),
        reconstruction=config["reconstruction"],
        metrics=METRICS,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} with two sources of poses"


rule pose_sources:
    input:
        evaluations=of_posed_twice("evaluation.parquet"),
        lib=library("pose_sources"),
    output:
        table=report(
            "<tables>/pose_sources.tex",
            caption="../report/pose_sources.rst",
            category="Paper",
            labels={"table": "Two sources of poses", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/pose_sources.csv",
            caption="../report/pose_sources.rst",
            category="Paper",
            labels={"table": "Two sources of poses", "form": "numbers"},
        ),
    log:
        "<results>/logs/pose_sources.log",
    benchmark:
        "<results>/benchmarks/pose_sources.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=lambda wildcards: posed_twice(),
        names=lambda wildcards: [
            f"{config['datasets'][posed_twice()[0][0]]['label']}, as distributed",
            config["pose_sources"]["label"],
        ],
        budgets=config["budgets"],
        metrics=METRICS,
        facts=lambda wildcards: facts([posed_twice()[0][0]]),
    message:
        "Writing what another source of poses costs"
    script:
        "../scripts/pose_sources.py"
