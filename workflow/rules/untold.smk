"""Selecting without being told what will be rendered. Not part of `rule all`.

Inputs: canonical captures of evaluation scenes with their descriptors; the shipped `fsel`.
Outputs: <results>/{dataset}/{scene}/untold.parquet, <tables>/untold.{tex,csv}, <figures>/untold.{pdf,png}.
"""


rule evaluate_untold:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        lib=library("evaluate_untold"),
    output:
        evaluation="<results>/{dataset}/{scene}/untold.parquet",
    log:
        "<results>/logs/evaluate_untold/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_untold/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(30),
        gpu=GPU,
    params:
        generated=lambda wildcards: generated(wildcards.dataset, wildcards.scene),
        budgets=config["budgets"],
        seed=lambda wildcards: scene_seed(wildcards, "untold"),
        reconstruction=config["reconstruction"],
    message:
        "Selecting from {wildcards.dataset}/{wildcards.scene} for views that nobody states"
    script:
        "../scripts/evaluate_untold.py"


rule untold:
    input:
        evaluations=[
            f"<results>/{d}/{s}/untold.parquet" for d, s in evaluation_scenes()
        ],
        lib=library("untold"),
    output:
        table=report(
            "<tables>/untold.tex",
            caption="../report/untold.rst",
            category="Beyond the paper",
            labels={"table": "Untold", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/untold.csv",
            caption="../report/untold.rst",
            category="Beyond the paper",
            labels={"table": "Untold", "form": "numbers"},
        ),
        figures=report(
            multiext("<figures>/untold", ".pdf", ".png"),
            caption="../report/untold.rst",
            category="Beyond the paper",
            labels={"figure": "Untold"},
        ),
    log:
        "<results>/logs/untold.log",
    benchmark:
        "<results>/benchmarks/untold.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=evaluation_scenes(),
        facts=facts(),
    message:
        "Writing what selections without a request are worth"
    script:
        "../scripts/untold.py"
