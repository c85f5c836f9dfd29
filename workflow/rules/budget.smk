"""The adaptive budget: what it predicts, fitted on train scenes, and what it is worth. None is part
of `rule all`.

Inputs: canonical captures of train scenes, problems of evaluation scenes, the selector `fsel`.
Outputs: <results>/selector/budget.{json,csv}, <tables>/budget.{tex,csv}.
"""


rule measure_curves:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights="<results>/selector/fsel/seed0.json",
        lib=library("measure_curves"),
    output:
        "<results>/{dataset}/{scene}/curves.parquet",
    log:
        "<results>/logs/measure_curves/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/measure_curves/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        coverages=config["coverages"],
        seed=lambda wildcards: scene_seed(wildcards, "budget"),
        reconstruction=config["reconstruction"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} from ever more frames"
    script:
        "../scripts/measure_curves.py"


rule fit_budget:
    input:
        curves=collect("<results>/{scene}/curves.parquet", scene=PRACTISED),
        lib=library("fit_budget"),
    output:
        record="<results>/selector/budget.json",
        comparison="<results>/selector/budget.csv",
    log:
        "<results>/logs/fit_budget.log",
    benchmark:
        "<results>/benchmarks/fit_budget.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scenes=PRACTISED,
    message:
        "Fitting what further frames bring"
    script:
        "../scripts/fit_budget.py"


rule measure_budgets:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights="<results>/selector/fsel/seed0.json",
        record="<results>/selector/budget.json",
        lib=library("measure_budgets"),
    output:
        "<results>/{dataset}/{scene}/budgets.parquet",
    log:
        "<results>/logs/measure_budgets/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/measure_budgets/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        budgets=config["budgets"],
        coverages=config["coverages"],
        auto=config["auto"],
        seed=lambda wildcards: scene_seed(wildcards, "budget"),
        reconstruction=config["reconstruction"],
    message:
        "Measuring adaptive and fixed budgets on {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/measure_budgets.py"


rule budget:
    input:
        measured=[f"<results>/{d}/{s}/budgets.parquet" for d, s in evaluation_scenes()],
        lib=library("budget"),
    output:
        table=report(
            "<tables>/budget.tex",
            caption="../report/budget.rst",
            category="Speed",
            labels={"table": "Adaptive budget", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/budget.csv",
            caption="../report/budget.rst",
            category="Speed",
            labels={"table": "Adaptive budget", "form": "numbers"},
        ),
    log:
        "<results>/logs/budget.log",
    benchmark:
        "<results>/benchmarks/budget.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scenes=evaluation_scenes(),
        datasets=labels(),
        auto=config["auto"],
        facts=facts(),
    message:
        "Writing the adaptive budget's table"
    script:
        "../scripts/budget.py"
