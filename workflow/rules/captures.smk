"""From recordings in any layout to canonical captures, the problems posed on them, and features.

Inputs: folders of captures on disk, or the network, or nothing for embedded ones.
Outputs: <downloads>/{archive}, <results>/data/{dataset}/{scene},
<results>/{dataset}/{scene}/{frames,points,descriptors}.parquet, images.npy and masks.npy,
<results>/{dataset}/{scene}/draw{draw}/{split,features}.parquet.
"""


# a download is not made anew because the code that made it has changed: no `lib`
use rule stage as download with:
    output:
        path="<downloads>/{archive}",
    log:
        "<results>/logs/download/{archive}.log",
    benchmark:
        "<results>/benchmarks/download/{archive}.jsonl"
    wildcard_constraints:
        archive=r"[^/]+\.zip",
    localrule: True
    resources:
        **experiment.resources(500, 1440),
    params:
        url=lambda wildcards: experiment.datasets.archive(wildcards)["url"],
        sha256=lambda wildcards: experiment.datasets.archive(wildcards)["sha256"],
    message:
        "Downloading {wildcards.archive}"


use rule stage as unpack with:
    input:
        archive=experiment.datasets.archive_of,
    output:
        folder=directory("<results>/data/{dataset}/{scene}"),
    log:
        "<results>/logs/unpack/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/unpack/{dataset}/{scene}.jsonl"
    wildcard_constraints:
        dataset=experiment.datasets.names("fetch"),
    resources:
        **experiment.resources(500, 120),
    params:
        inside=lambda wildcards: experiment.datasets.fetched(wildcards)["inside"],
        files=lambda wildcards: experiment.datasets.fetched(wildcards)["files"],
        licence=lambda wildcards: experiment.datasets.fetched(wildcards)["licence"],
        most=lambda wildcards: experiment.datasets.fetched(wildcards)["most_gb"],
    message:
        "Unpacking {wildcards.dataset}/{wildcards.scene}"


use rule stage as generate with:
    output:
        folder=directory("<results>/data/{dataset}/{scene}"),
    log:
        "<results>/logs/generate/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/generate/{dataset}/{scene}.jsonl"
    wildcard_constraints:
        dataset=experiment.datasets.names("embedded"),
    resources:
        **experiment.resources(2000),
    params:
        lib=experiment.library("generate"),
        frames=lambda wildcards: experiment.embedded_frames(wildcards.dataset),
        width=lambda wildcards: experiment.embedded_size(wildcards)[0],
        height=lambda wildcards: experiment.embedded_size(wildcards)[1],
        layout=lambda wildcards: experiment.datasets.entries[wildcards.dataset][
            "layout"
        ],
        family=lambda wildcards: experiment.datasets.entries[wildcards.dataset][
            "embedded"
        ]["family"],
        seed=experiment.scene_seed,
    message:
        "Generating the embedded capture {wildcards.dataset}/{wildcards.scene}"


use rule stage as ingest with:
    input:
        source=kept_here(experiment.datasets.raw_capture),
    output:
        **inputs.capture(),
    log:
        "<results>/logs/ingest/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/ingest/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(2000)
        | {"runtime": experiment.ingest_minutes, "gpu": experiment.ingest_gpus},
    params:
        **inputs.ingested(experiment, experiment.config["long_side"]),
        lib=experiment.library("ingest"),
    message:
        "Reading the capture {wildcards.dataset}/{wildcards.scene}"


use rule stage as describe with:
    input:
        **inputs.capture(),
    output:
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
    log:
        "<results>/logs/describe/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/describe/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(2000, 30, "capture"),
    params:
        **experiment.config["appearance"],
        lib=experiment.library("describe"),
    message:
        "Describing the frames of {wildcards.dataset}/{wildcards.scene}"


use rule stage as split with:
    input:
        **inputs.capture(),
    output:
        splits=inputs.of_draws(experiment, "split.parquet"),
    log:
        "<results>/logs/split/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/split/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(grows="capture"),
    params:
        lib=experiment.library("split"),
        hold_out=experiment.config["hold_out"],
        targets=experiment.config["targets"],
        seed=lambda wildcards: experiment.scene_seed(wildcards, "split"),
    message:
        "Drawing the targets of {wildcards.dataset}/{wildcards.scene}"


use rule stage as features with:
    input:
        **inputs.capture(inputs.DESCRIBED),
        splits=inputs.of_draws(experiment, "split.parquet"),
    output:
        tables=inputs.of_draws(experiment, "features.parquet"),
    log:
        "<results>/logs/features/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/features/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(grows="capture"),
    params:
        lib=experiment.library("features"),
    message:
        "Computing the features of {wildcards.dataset}/{wildcards.scene}"
