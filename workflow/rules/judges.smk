"""The same picks under the further reconstructors of `reconstruction`, when it is a list.

Inputs: problems and picks.
Outputs: <results>/{dataset}/{scene}/draw{draw}/{judge}/evaluation.parquet,
<tables>/{judge}/{ksweep,handsign,seedvar}.{tex,csv}, <tables>/{judge}/ksweep_differences.csv,
<figures>/{judge}/heatmap.{pdf,png}.
"""


wildcard_constraints:
    judge=r"[A-Za-z0-9][A-Za-z0-9_.-]*",


use rule evaluate as evaluate_further with:
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
        lib=lambda wildcards: library("evaluate", judge_of(wildcards)["name"]),
    output:
        evaluations=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/{{judge}}/evaluation.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/evaluate/{judge}/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate/{judge}/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(180),
        gpu=lambda wildcards: int(needs_gpu(judge_of(wildcards))),
    params:
        reconstruction=judge_of,
        metrics=METRICS,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} by {wildcards.judge}"


use rule ksweep as ksweep_further with:
    input:
        evaluations=collect(
            "<results>/{problem}/{{judge}}/evaluation.parquet",
            problem=evaluation_problems(config["draws"]),
        ),
        oracles=[],
        lib=library("ksweep"),
    output:
        table=report(
            "<tables>/{judge}/ksweep.tex",
            caption="../report/ksweep.rst",
            category="Tables",
            labels={"table": "Input budget sweep, {judge}", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/{judge}/ksweep.csv",
            caption="../report/ksweep.rst",
            category="Tables",
            labels={"table": "Input budget sweep, {judge}", "form": "numbers"},
        ),
        differences=report(
            "<tables>/{judge}/ksweep_differences.csv",
            caption="../report/ksweep.rst",
            category="Tables",
            labels={"table": "Paired differences, {judge}", "form": "numbers"},
        ),
    log:
        "<results>/logs/ksweep/{judge}.log",
    benchmark:
        "<results>/benchmarks/ksweep/{judge}.jsonl"
    params:
        problems=evaluation_problems(config["draws"]),
        searched=[],
        datasets=labels(),
        budgets=config["budgets"],
        metrics=METRICS,
        facts=judge_facts,
    message:
        "Writing the budget sweep by {wildcards.judge}"


use rule heatmap as heatmap_further with:
    input:
        numbers="<tables>/{judge}/ksweep.csv",
        differences="<tables>/{judge}/ksweep_differences.csv",
        lib=library("heatmap"),
    output:
        figures=report(
            multiext("<figures>/{judge}/heatmap", ".pdf", ".png"),
            caption="../report/heatmap.rst",
            category="Heatmaps",
            labels={"figure": "Gain over the strongest baseline, {judge}"},
        ),
        cells="<tables>/{judge}/heatmap.csv",
    log:
        "<results>/logs/heatmap/{judge}.log",
    benchmark:
        "<results>/benchmarks/heatmap/{judge}.jsonl"
    params:
        datasets=labels(),
        budgets=config["budgets"],
        judge=lambda wildcards: wildcards.judge,
    message:
        "Drawing the gain over the strongest baseline by {wildcards.judge}"


use rule handsign as handsign_further with:
    input:
        evaluations=collect(
            "<results>/{problem}/{{judge}}/evaluation.parquet",
            problem=evaluation_problems(config["draws"]),
        ),
        lib=library("handsign"),
    output:
        table=report(
            "<tables>/{judge}/handsign.tex",
            caption="../report/handsign.rst",
            category="Paper",
            labels={"table": "Learned versus untrained, {judge}", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/{judge}/handsign.csv",
            caption="../report/handsign.rst",
            category="Paper",
            labels={"table": "Learned versus untrained, {judge}", "form": "numbers"},
        ),
    log:
        "<results>/logs/handsign/{judge}.log",
    benchmark:
        "<results>/benchmarks/handsign/{judge}.jsonl"
    params:
        **{**WHOLE, "facts": judge_facts},
        problems=evaluation_problems(config["draws"]),


use rule seedvar as seedvar_further with:
    input:
        evaluations=collect(
            "<results>/{problem}/{{judge}}/evaluation.parquet",
            problem=evaluation_problems(config["draws"]),
        ),
        lib=library("seedvar"),
    output:
        table=report(
            "<tables>/{judge}/seedvar.tex",
            caption="../report/seedvar.rst",
            category="Paper",
            labels={"table": "Seed variability, {judge}", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/{judge}/seedvar.csv",
            caption="../report/seedvar.rst",
            category="Paper",
            labels={"table": "Seed variability, {judge}", "form": "numbers"},
        ),
    log:
        "<results>/logs/seedvar/{judge}.log",
    benchmark:
        "<results>/benchmarks/seedvar/{judge}.jsonl"
    params:
        **{**WHOLE, "facts": judge_facts},
        problems=evaluation_problems(config["draws"]),
