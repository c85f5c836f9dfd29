"""Ours with the freedom of its baselines, and what the numbers inside fsel are worth.

Inputs: problems and trained selectors; canonical captures of train scenes.
Outputs: <results>/{dataset}/{scene}/{freedom_picks,freedom,constants}.parquet,
<tables>/{freedom,fsel_constants}.{tex,csv}.
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


rule measure_constants:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        lib=library("measure_constants"),
    output:
        measured="<results>/{dataset}/{scene}/constants.parquet",
    log:
        "<results>/logs/measure_constants/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/measure_constants/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        **{key: config["refinement"][key] for key in ("draws", "targets", "budgets")},
        seed=lambda wildcards: scene_seed(wildcards, "constants"),
        reconstruction=config["reconstruction"],
    message:
        "Trying other numbers in fsel on {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/measure_constants.py"


rule fsel_constants:
    input:
        measured=collect("<results>/{scene}/constants.parquet", scene=PRACTISED),
        lib=library("fsel_constants"),
    output:
        table=report(
            "<tables>/fsel_constants.tex",
            caption="../report/fsel_constants.rst",
            category="Paper",
            labels={"table": "Numbers of fsel", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/fsel_constants.csv",
            caption="../report/fsel_constants.rst",
            category="Paper",
            labels={"table": "Numbers of fsel", "form": "numbers"},
        ),
    log:
        "<results>/logs/fsel_constants.log",
    benchmark:
        "<results>/benchmarks/fsel_constants.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=PRACTISED,
        budgets=config["refinement"]["budgets"],
        facts=facts(list(dict.fromkeys(scene.split("/")[0] for scene in PRACTISED))),
    message:
        "Writing what the numbers of fsel are worth"
    script:
        "../scripts/fsel_constants.py"
