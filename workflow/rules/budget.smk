"""The adaptive budget: what it predicts, fitted on train scenes, and what it is worth. None is part
of `rule all`.

Inputs: canonical captures of train scenes, problems of evaluation scenes, the selector `fsel`.
Outputs: <results>/{dataset}/{scene}/{curves_picks,curves,budgets_picks,budgets}.parquet,
<results>/selector/budget.{json,csv}, <tables>/budget.{tex,csv}.
"""


rule select_curves:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=FSEL[0],
        lib=library("select_curves"),
    output:
        picks="<results>/{dataset}/{scene}/curves_picks.parquet",
    log:
        "<results>/logs/select_curves/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_curves/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(2000),
        runtime=per_capture(10),
    params:
        coverages=config["coverages"],
        seed=lambda wildcards: scene_seed(wildcards, "budget"),
    message:
        "Selecting ever more frames of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/select_curves.py"


rule evaluate_curves:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/curves_picks.parquet",
        lib=library("evaluate_curves"),
    output:
        curves="<results>/{dataset}/{scene}/curves.parquet",
    log:
        "<results>/logs/evaluate_curves/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_curves/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(30),
        gpu=GPU,
    params:
        seed=lambda wildcards: scene_seed(wildcards, "budget"),
        reconstruction=config["reconstruction"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} from ever more frames"
    script:
        "../scripts/evaluate_curves.py"


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
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=[name.split("/") for name in PRACTISED],
    message:
        "Fitting what further frames bring"
    script:
        "../scripts/fit_budget.py"


rule select_budgets:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=FSEL[0],
        record="<results>/selector/budget.json",
        lib=library("select_budgets"),
    output:
        picks="<results>/{dataset}/{scene}/budgets_picks.parquet",
    log:
        "<results>/logs/select_budgets/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_budgets/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(2000),
        runtime=per_capture(10),
    params:
        budgets=config["budgets"],
        coverages=config["coverages"],
        auto=config["auto"],
        seed=lambda wildcards: scene_seed(wildcards, "budget"),
        long_side=config["reconstruction"]["long_side"],
    message:
        "Selecting adaptive and fixed numbers of frames of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/select_budgets.py"


rule evaluate_budgets:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/budgets_picks.parquet",
        lib=library("evaluate_budgets"),
    output:
        evaluation="<results>/{dataset}/{scene}/budgets.parquet",
    log:
        "<results>/logs/evaluate_budgets/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_budgets/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(30),
        gpu=GPU,
    params:
        seed=lambda wildcards: scene_seed(wildcards, "budget"),
        reconstruction=config["reconstruction"],
    message:
        "Measuring adaptive and fixed budgets on {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/evaluate_budgets.py"


rule budget:
    input:
        evaluations=[
            f"<results>/{d}/{s}/budgets.parquet" for d, s in evaluation_scenes()
        ],
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
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=evaluation_scenes(),
        datasets=labels(),
        auto=config["auto"],
        facts=facts(),
    message:
        "Writing the adaptive budget's table"
    script:
        "../scripts/budget.py"
