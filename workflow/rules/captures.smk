"""From recordings in any layout to canonical captures and the problems posed on them.

Inputs: folders of captures on disk, or nothing for embedded ones.
Outputs: <results>/{dataset}/{scene}/{frames,points,descriptors}.parquet and images.npy,
<results>/{dataset}/{scene}/draw{draw}/{split,features}.parquet.
"""


rule generate:
    input:
        lib=library("generate"),
    output:
        folder=directory("<results>/data/{dataset}/{scene}"),
    log:
        "<results>/logs/generate/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/generate/{dataset}/{scene}.jsonl"
    wildcard_constraints:
        dataset=datasets_with("embedded"),
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(2000),
        runtime=growing(10),
    params:
        **config["embedded"],
        layout=lambda wildcards: config["datasets"][wildcards.dataset]["layout"],
        family=lambda wildcards: config["datasets"][wildcards.dataset]["embedded"][
            "family"
        ],
        seed=lambda wildcards: scene_seed(wildcards),
    message:
        "Generating the embedded capture {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/generate.py"


rule ingest:
    input:
        source=raw_capture,
        lib=library("ingest"),
    output:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
    log:
        "<results>/logs/ingest/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/ingest/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(2000),
        runtime=lambda wildcards, attempt: attempt
        * (240 if config["datasets"][wildcards.dataset]["poses"] == "colmap" else 30),
    params:
        reading=lambda wildcards: reading(wildcards.dataset, wildcards.scene),
        long_side=config["long_side"],
        at_least=lambda wildcards: frames_needed(
            role_of(wildcards.dataset, wildcards.scene)
        ),
    message:
        "Reading the capture {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/ingest.py"


rule describe:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=library("describe"),
    output:
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
    log:
        "<results>/logs/describe/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/describe/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(2000),
        runtime=per_capture(30),
    params:
        **config["appearance"],
    message:
        "Describing the frames of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/describe.py"


rule split:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=library("split"),
    output:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/split/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/split/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(1000),
        runtime=per_capture(10),
    params:
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "split"),
    message:
        "Drawing the targets of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/split.py"


rule features:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        lib=library("features"),
    output:
        tables=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/features.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/features/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/features/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(1000),
        runtime=per_capture(10),
    message:
        "Computing the features of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/features.py"
