"""Ours with the freedom of its baselines.

Inputs: problems and trained selectors.
Outputs: <results>/{dataset}/{scene}/{freedom_picks,freedom}.parquet, <tables>/freedom.{tex,csv}.
"""


rule select_freedom:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=OURS,
        rules=FSEL,
        lib=library("select_freedom"),
    output:
        picks="<results>/{dataset}/{scene}/freedom_picks.parquet",
    log:
        "<results>/logs/select_freedom/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_freedom/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
    params:
        budgets=config["budgets"],
        seeds=lambda wildcards: [
            scene_seed(wildcards, "select", draw) for draw in range(config["draws"])
        ],
    message:
        "Selecting frames of {wildcards.dataset}/{wildcards.scene} with equal freedom"
    script:
        "../scripts/select_freedom.py"


rule evaluate_freedom:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/freedom_picks.parquet",
        lib=library("evaluate_freedom"),
    output:
        evaluation="<results>/{dataset}/{scene}/freedom.parquet",
    log:
        "<results>/logs/evaluate_freedom/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_freedom/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=GPU,
    params:
        reconstruction=config["reconstruction"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} with equal freedom"
    script:
        "../scripts/evaluate_freedom.py"


rule freedom:
    input:
        evaluations=[
            f"<results>/{d}/{s}/freedom.parquet" for d, s in evaluation_scenes()
        ],
        lib=library("freedom"),
    output:
        table=report(
            "<tables>/freedom.tex",
            caption="../report/freedom.rst",
            category="Paper",
            labels={"table": "Equal freedom", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/freedom.csv",
            caption="../report/freedom.rst",
            category="Paper",
            labels={"table": "Equal freedom", "form": "numbers"},
        ),
    log:
        "<results>/logs/freedom.log",
    benchmark:
        "<results>/benchmarks/freedom.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=evaluation_scenes(),
        budgets=config["budgets"],
        facts=facts(),
    message:
        "Writing ours and the baselines with equal freedom"
    script:
        "../scripts/freedom.py"
