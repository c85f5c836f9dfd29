"""Selectors on poses estimated from the images, and on poses with noise.

Inputs: raw and canonical captures of every dataset's first evaluation scene, trained selectors.
Outputs: <results>/{dataset}/{scene}/poses/{given,estimated}/ (canonical captures),
<results>/{dataset}/{scene}/poses/{errors,estimated,noise,estimated_picks,noise_picks}.parquet, <tables>/poses.{tex,csv},
<figures>/pose_noise.{pdf,png,csv}.
"""

# of a capture of few frames, larger budgets would take nearly all
TRIED = [k for k in config["budgets"] if k <= budget_near(30)]
NOISY = {key: config["inexact_poses"][key] for key in ("degrees", "percent")}


use rule generate as generate_large with:
    output:
        folder=directory("<results>/{dataset}/{scene}/poses/data"),
    log:
        "<results>/logs/generate_large/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/generate_large/{dataset}/{scene}.jsonl"
    params:
        **{key: config["inexact_poses"][key] for key in ("frames", "width", "height")},
        layout=lambda wildcards: config["datasets"][wildcards.dataset]["layout"],
        family=lambda wildcards: config["datasets"][wildcards.dataset]["embedded"][
            "family"
        ],
        seed=lambda wildcards: scene_seed(wildcards),
    message:
        "Generating {wildcards.dataset}/{wildcards.scene} with large images"


rule estimate_poses:
    input:
        source=large_capture,
        lib=library("estimate_poses"),
    output:
        given_frames="<results>/{dataset}/{scene}/poses/given/frames.parquet",
        given_points="<results>/{dataset}/{scene}/poses/given/points.parquet",
        given_images="<results>/{dataset}/{scene}/poses/given/images.npy",
        estimated_frames="<results>/{dataset}/{scene}/poses/estimated/frames.parquet",
        estimated_points="<results>/{dataset}/{scene}/poses/estimated/points.parquet",
        estimated_images="<results>/{dataset}/{scene}/poses/estimated/images.npy",
        errors="<results>/{dataset}/{scene}/poses/errors.parquet",
    log:
        "<results>/logs/estimate_poses/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/estimate_poses/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
    params:
        frames=config["inexact_poses"]["frames"],
        matching_side=max(
            config["inexact_poses"]["width"], config["inexact_poses"]["height"]
        ),
        long_side=config["long_side"],
        at_least=frames_to_place(),
        reading=lambda wildcards: reading(wildcards.dataset, wildcards.scene),
    message:
        "Estimating the poses of {wildcards.dataset}/{wildcards.scene} from its images"
    script:
        "../scripts/estimate_poses.py"


use rule describe as describe_posed with:
    input:
        frames="<results>/{dataset}/{scene}/poses/given/frames.parquet",
        images="<results>/{dataset}/{scene}/poses/given/images.npy",
        lib=library("describe"),
    output:
        descriptors="<results>/{dataset}/{scene}/poses/given/descriptors.parquet",
    log:
        "<results>/logs/describe_posed/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/describe_posed/{dataset}/{scene}.jsonl"


rule select_estimated:
    input:
        given_frames="<results>/{dataset}/{scene}/poses/given/frames.parquet",
        given_points="<results>/{dataset}/{scene}/poses/given/points.parquet",
        given_images="<results>/{dataset}/{scene}/poses/given/images.npy",
        estimated_frames="<results>/{dataset}/{scene}/poses/estimated/frames.parquet",
        estimated_points="<results>/{dataset}/{scene}/poses/estimated/points.parquet",
        estimated_images="<results>/{dataset}/{scene}/poses/estimated/images.npy",
        given_descriptors="<results>/{dataset}/{scene}/poses/given/descriptors.parquet",
        weights=SCORERS,
        lib=library("select_estimated"),
    output:
        picks="<results>/{dataset}/{scene}/poses/estimated_picks.parquet",
    log:
        "<results>/logs/select_estimated/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_estimated/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
    params:
        draws=config["draws"],
        budgets=TRIED,
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "poses"),
        split_seed=lambda wildcards: scene_seed(wildcards, "split"),
    message:
        "Selecting on given and estimated poses of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/select_estimated.py"


rule evaluate_estimated:
    input:
        given_frames="<results>/{dataset}/{scene}/poses/given/frames.parquet",
        given_points="<results>/{dataset}/{scene}/poses/given/points.parquet",
        given_images="<results>/{dataset}/{scene}/poses/given/images.npy",
        estimated_frames="<results>/{dataset}/{scene}/poses/estimated/frames.parquet",
        estimated_points="<results>/{dataset}/{scene}/poses/estimated/points.parquet",
        estimated_images="<results>/{dataset}/{scene}/poses/estimated/images.npy",
        picks="<results>/{dataset}/{scene}/poses/estimated_picks.parquet",
        lib=library("evaluate_estimated"),
    output:
        evaluation="<results>/{dataset}/{scene}/poses/estimated.parquet",
    log:
        "<results>/logs/evaluate_estimated/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_estimated/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        targets=config["targets"],
        split_seed=lambda wildcards: scene_seed(wildcards, "split"),
        reconstruction=config["reconstruction"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} with given and estimated poses"
    script:
        "../scripts/evaluate_estimated.py"


rule select_noise:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=SCORERS,
        lib=library("select_noise"),
    output:
        picks="<results>/{dataset}/{scene}/poses/noise_picks.parquet",
    log:
        "<results>/logs/select_noise/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_noise/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
    params:
        levels=NOISY,
        noises=config["inexact_poses"]["noises"],
        budgets=[budget_near(30)],
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "poses"),
        split_seed=lambda wildcards: scene_seed(wildcards, "split"),
    message:
        "Selecting on poses of {wildcards.dataset}/{wildcards.scene} with noise"
    script:
        "../scripts/select_noise.py"


rule evaluate_noise:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/poses/noise_picks.parquet",
        lib=library("evaluate_noise"),
    output:
        evaluation="<results>/{dataset}/{scene}/poses/noise.parquet",
    log:
        "<results>/logs/evaluate_noise/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_noise/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "poses"),
        split_seed=lambda wildcards: scene_seed(wildcards, "split"),
        reconstruction=config["reconstruction"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} with noise in its poses"
    script:
        "../scripts/evaluate_noise.py"


rule poses:
    input:
        estimated=of_posed("estimated.parquet"),
        noise=of_posed("noise.parquet"),
        errors=of_posed("errors.parquet"),
        lib=library("poses"),
    output:
        table=report(
            "<tables>/poses.tex",
            caption="../report/poses.rst",
            category="Paper",
            labels={"table": "Estimated and noisy poses", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/poses.csv",
            caption="../report/poses.rst",
            category="Paper",
            labels={"table": "Estimated and noisy poses", "form": "numbers"},
        ),
        figures=report(
            multiext("<figures>/pose_noise", ".pdf", ".png"),
            caption="../report/poses.rst",
            category="Paper",
            labels={"figure": "Noise in poses"},
        ),
        drawn="<figures>/pose_noise.csv",
    log:
        "<results>/logs/poses.log",
    benchmark:
        "<results>/benchmarks/poses.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=first_scenes(),
        budgets=TRIED,
        facts=facts(),
    message:
        "Writing what inexact poses cost"
    script:
        "../scripts/poses.py"
