"""Captures that anybody may download.

Inputs: the network.
Outputs: <downloads>/{archive}, <results>/data/{dataset}/{scene}.
"""


rule download:
    output:
        path="<downloads>/{archive}",
    log:
        "<results>/logs/download/{archive}.log",
    benchmark:
        "<results>/benchmarks/download/{archive}.jsonl"
    wildcard_constraints:
        archive=r"[^/]+\.zip",
    localrule: True
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(500),
        runtime=growing(1440),
    params:
        url=lambda wildcards: archive(wildcards.archive)["url"],
        sha256=lambda wildcards: archive(wildcards.archive)["sha256"],
    message:
        "Downloading {wildcards.archive}"
    script:
        "../scripts/download.py"


rule unpack:
    input:
        archive=lambda wildcards: f"<downloads>/{archive_of(wildcards.dataset, wildcards.scene)}",
    output:
        folder=directory("<results>/data/{dataset}/{scene}"),
    log:
        "<results>/logs/unpack/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/unpack/{dataset}/{scene}.jsonl"
    wildcard_constraints:
        dataset=datasets_with("fetch"),
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(500),
        runtime=growing(120),
    params:
        inside=lambda wildcards: inside(wildcards.dataset, wildcards.scene),
    message:
        "Unpacking {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/unpack.py"
