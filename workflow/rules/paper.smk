"""The paper's other tables and figures. None is part of `rule all`; `paper` makes them all.

Inputs: evaluations, searches, labels, trained selectors and canonical captures.
Outputs: <tables>/{handsign,seedvar,ga_vs_learned}.{tex,csv},
<results>/{dataset}/{scene}/draw{draw}/searched.parquet.
"""

WHOLE = {
    "datasets": labels(),
    "budgets": config["budgets"],
    "bootstrap": config["bootstrap"] | {"seed": config["seed"]},
    "facts": facts(),
}


rule handsign:
    input:
        evaluations=collect(
            "<results>/{problem}/evaluation.parquet", problem=problems(config["draws"])
        ),
        lib=library("report", "experiments/comparisons", "pipeline/tables"),
    output:
        table=report(
            "<tables>/handsign.tex",
            caption="../report/handsign.rst",
            category="Paper",
            labels={"table": "Learned versus untrained", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/handsign.csv",
            caption="../report/handsign.rst",
            category="Paper",
            labels={"table": "Learned versus untrained", "form": "numbers"},
        ),
    log:
        "<results>/logs/handsign.log",
    benchmark:
        "<results>/benchmarks/handsign.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        **WHOLE,
        problems=problems(config["draws"]),
    message:
        "Writing what learning adds"
    script:
        "../scripts/handsign.py"


rule seedvar:
    input:
        evaluations=collect(
            "<results>/{problem}/evaluation.parquet", problem=problems(config["draws"])
        ),
        lib=library("report", "experiments/comparisons", "pipeline/tables"),
    output:
        table=report(
            "<tables>/seedvar.tex",
            caption="../report/seedvar.rst",
            category="Paper",
            labels={"table": "Seed variability", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/seedvar.csv",
            caption="../report/seedvar.rst",
            category="Paper",
            labels={"table": "Seed variability", "form": "numbers"},
        ),
    log:
        "<results>/logs/seedvar.log",
    benchmark:
        "<results>/benchmarks/seedvar.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        **WHOLE,
        problems=problems(config["draws"]),
    message:
        "Writing how far training seeds spread"
    script:
        "../scripts/seedvar.py"


rule measure_searched:
    input:
        split="<results>/{dataset}/{scene}/draw{draw}/split.parquet",
        subsets="<results>/{dataset}/{scene}/draw{draw}/subsets.parquet",
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=library(*RECONSTRUCTION, *FILES, "experiments/searches", "pipeline/labels"),
    output:
        "<results>/{dataset}/{scene}/draw{draw}/searched.parquet",
    log:
        "<results>/logs/measure_searched/{dataset}/{scene}/draw{draw}.log",
    benchmark:
        "<results>/benchmarks/measure_searched/{dataset}/{scene}/draw{draw}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=60,
    params:
        reconstruction=config["reconstruction"],
    message:
        "Scoring the searched subsets of {wildcards.dataset}/{wildcards.scene} on the targets"
    script:
        "../scripts/measure_searched.py"


rule ga_vs_learned:
    input:
        evaluations=of_held_out("evaluation.parquet"),
        oracles=of_held_out("oracle.parquet"),
        searched=of_held_out("searched.parquet"),
        lib=library("report", "experiments/searches", "pipeline/tables"),
    output:
        table=report(
            "<tables>/ga_vs_learned.tex",
            caption="../report/ga_vs_learned.rst",
            category="Paper",
            labels={"table": "Comparison with the search", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/ga_vs_learned.csv",
            caption="../report/ga_vs_learned.rst",
            category="Paper",
            labels={"table": "Comparison with the search", "form": "numbers"},
        ),
    log:
        "<results>/logs/ga_vs_learned.log",
    benchmark:
        "<results>/benchmarks/ga_vs_learned.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        problems=lambda wildcards: held_out_problems(),
        k=config["search"]["k"],
        bootstrap=config["bootstrap"] | {"seed": config["seed"]},
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Comparing the selectors with the search"
    script:
        "../scripts/ga_vs_learned.py"


rule paper:
    input:
        "<tables>/handsign.tex",
        "<tables>/seedvar.tex",
        "<tables>/ga_vs_learned.tex",
    localrule: True
