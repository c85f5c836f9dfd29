"""Every method on every evaluation problem, and what came of it.

Inputs: problems and trained selectors.
Outputs: <results>/{dataset}/{scene}/draw{draw}/{selections,evaluation}.parquet, the searches'
{subsets,oracle}.parquet, <tables>/ksweep.{tex,csv}, <tables>/ksweep_differences.csv,
<figures>/heatmap.{pdf,png}.
"""


rule select:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        features=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/features.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=SCORERS,
        lib=library("select"),
    output:
        selections=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/selections.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/select/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(2000),
        runtime=per_capture(30),
    params:
        budgets=config["budgets"],
        seeds=lambda wildcards: [
            scene_seed(wildcards, "select", draw) for draw in range(config["draws"])
        ],
    message:
        "Selecting frames of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/select.py"


rule evaluate:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        selections=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/selections.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=library("evaluate"),
    output:
        evaluations=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/evaluation.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/evaluate/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(180),
        gpu=GPU,
    params:
        reconstruction=config["reconstruction"],
        metrics=METRICS,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} from every selection"
    script:
        "../scripts/evaluate.py"


rule search_oracle:
    input:
        split="<results>/{dataset}/{scene}/draw{draw}/split.parquet",
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        lib=library("search_oracle"),
    output:
        subsets="<results>/{dataset}/{scene}/draw{draw}/subsets.parquet",
        oracle="<results>/{dataset}/{scene}/draw{draw}/oracle.parquet",
    log:
        "<results>/logs/search_oracle/{dataset}/{scene}/draw{draw}.log",
    benchmark:
        "<results>/benchmarks/search_oracle/{dataset}/{scene}/draw{draw}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=GPU,
    params:
        search=config["search"],
        reconstruction=config["reconstruction"],
        fitness=FITNESS,
        metrics=METRICS,
        seed=lambda wildcards: scene_seed(wildcards, "oracle", wildcards.draw),
    message:
        "Searching {wildcards.dataset}/{wildcards.scene}, draw {wildcards.draw}, to compare with"
    script:
        "../scripts/search_oracle.py"


rule ksweep:
    input:
        evaluations=collect(
            "<results>/{problem}/evaluation.parquet",
            problem=evaluation_problems(config["draws"]),
        ),
        oracles=collect(
            "<results>/{problem}/oracle.parquet",
            problem=searched_problems(),
        ),
        lib=library("ksweep"),
    output:
        table=report(
            "<tables>/ksweep.tex",
            caption="../report/ksweep.rst",
            category="Tables",
            labels={"table": "Input budget sweep", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/ksweep.csv",
            caption="../report/ksweep.rst",
            category="Tables",
            labels={"table": "Input budget sweep", "form": "numbers"},
        ),
        differences=report(
            "<tables>/ksweep_differences.csv",
            caption="../report/ksweep.rst",
            category="Tables",
            labels={"table": "Paired differences", "form": "numbers"},
        ),
    log:
        "<results>/logs/ksweep.log",
    benchmark:
        "<results>/benchmarks/ksweep.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        problems=evaluation_problems(config["draws"]),
        searched=searched_problems(),
        datasets=labels(),
        budgets=config["budgets"],
        metrics=METRICS,
        facts=facts(),
    message:
        "Writing the budget sweep"
    script:
        "../scripts/ksweep.py"


rule heatmap:
    input:
        numbers="<tables>/ksweep.csv",
        differences="<tables>/ksweep_differences.csv",
        lib=library("heatmap"),
    output:
        figures=report(
            multiext("<figures>/heatmap", ".pdf", ".png"),
            caption="../report/heatmap.rst",
            category="Heatmaps",
            labels={"figure": "Gain over the strongest baseline"},
        ),
        cells="<tables>/heatmap.csv",
    log:
        "<results>/logs/heatmap.log",
    benchmark:
        "<results>/benchmarks/heatmap.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        datasets=labels(),
        budgets=config["budgets"],
    message:
        "Drawing the gain over the strongest baseline"
    script:
        "../scripts/heatmap.py"
