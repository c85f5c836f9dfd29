"""Several reconstructors side by side, on the picks of the sweep. Part of `paper` alone.

Inputs: problems and picks of the training dataset's evaluation scenes.
Outputs: <results>/{dataset}/{scene}/draw{draw}/{judge}/{transfer,reconchoice}.parquet,
<tables>/{transfer,reconchoice}.{tex,csv}, <tables>/transfer_differences.csv.
"""


rule evaluate_transfer:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=COMPARED_DRAWS,
        ),
        selections=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/selections.parquet",
            draw=COMPARED_DRAWS,
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=lambda wildcards: library(
            "evaluate_transfer", compared_by(wildcards)["name"]
        ),
    output:
        evaluations=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/{{judge}}/transfer.parquet",
            draw=COMPARED_DRAWS,
        ),
    log:
        "<results>/logs/evaluate_transfer/{judge}/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_transfer/{judge}/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=lambda wildcards: int(needs_gpu(compared_by(wildcards))),
    params:
        reconstruction=compared_by,
        metrics=METRICS,
        budgets=lambda wildcards: compared_budgets("budgets"),
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} by {wildcards.judge}"
    script:
        "../scripts/evaluate_transfer.py"


rule transfer:
    input:
        evaluations=of_compared("transfer.parquet", COMPARED_DRAWS),
        lib=library("transfer"),
    output:
        table=report(
            "<tables>/transfer.tex",
            caption="../report/transfer.rst",
            category="Paper",
            labels={"table": "Other reconstructors", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/transfer.csv",
            caption="../report/transfer.rst",
            category="Paper",
            labels={"table": "Other reconstructors", "form": "numbers"},
        ),
        differences=report(
            "<tables>/transfer_differences.csv",
            caption="../report/transfer.rst",
            category="Paper",
            labels={"table": "Other reconstructors, differences", "form": "numbers"},
        ),
    log:
        "<results>/logs/transfer.log",
    benchmark:
        "<results>/benchmarks/transfer.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        problems=lambda wildcards: [
            f"{TRAINED}/{scene}/draw{n}"
            for scene in held_out_scenes()
            for n in COMPARED_DRAWS
        ],
        judges=lambda wildcards: compared_facts(),
        budgets=lambda wildcards: compared_budgets("budgets"),
        metrics=METRICS,
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Writing what the picks are worth under other reconstructors"
    script:
        "../scripts/transfer.py"


rule evaluate_reconchoice:
    input:
        split="<results>/{dataset}/{scene}/draw{draw}/split.parquet",
        selections="<results>/{dataset}/{scene}/draw{draw}/selections.parquet",
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=lambda wildcards: library(
            "evaluate_reconchoice", compared_by(wildcards)["name"]
        ),
    output:
        evaluation="<results>/{dataset}/{scene}/draw{draw}/{judge}/reconchoice.parquet",
    log:
        "<results>/logs/evaluate_reconchoice/{judge}/{dataset}/{scene}/draw{draw}.log",
    benchmark:
        "<results>/benchmarks/evaluate_reconchoice/{judge}/{dataset}/{scene}/draw{draw}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(config["transfer"]["memory"] // 1_000_000),
        runtime=growing(60),
        gpu=lambda wildcards: int(needs_gpu(compared_by(wildcards))),
    params:
        reconstruction=compared_by,
        metrics=METRICS,
        budgets=lambda wildcards: compared_budgets("inputs"),
        memory=config["transfer"]["memory"],
    message:
        "Measuring {wildcards.judge} on {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/evaluate_reconchoice.py"


rule reconchoice:
    input:
        evaluations=of_compared("reconchoice.parquet", [0]),
        lib=library("reconchoice"),
    output:
        table=report(
            "<tables>/reconchoice.tex",
            caption="../report/reconchoice.rst",
            category="Paper",
            labels={"table": "Reconstructors", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/reconchoice.csv",
            caption="../report/reconchoice.rst",
            category="Paper",
            labels={"table": "Reconstructors", "form": "numbers"},
        ),
    log:
        "<results>/logs/reconchoice.log",
    benchmark:
        "<results>/benchmarks/reconchoice.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        judges=lambda wildcards: compared_facts(),
        metrics=METRICS,
        memory=config["transfer"]["memory"],
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Comparing reconstructors"
    script:
        "../scripts/reconchoice.py"
