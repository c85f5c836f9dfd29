"""What selection costs, beside what it is worth.

Inputs: a canonical capture, problems, trained selectors and their evaluations.
Outputs: <tables>/selection_time.{tex,csv}, <figures>/speed.{pdf,png}, <tables>/fisher_damping.{tex,csv}.
"""

TIMED = "/".join(evaluation_scenes()[0])
MEASURED = problems(config["oracle"]["draws"])
SWEPT = problems(1)


rule selection_time:
    input:
        frames=f"<results>/{TIMED}/frames.parquet",
        points=f"<results>/{TIMED}/points.parquet",
        images=f"<results>/{TIMED}/images.npy",
        ours=collect("<results>/selector/seed{seed}.safetensors", seed=SEEDS),
        ours_no_appearance=collect(
            "<results>/selector/no_appearance/seed{seed}.safetensors", seed=SEEDS
        ),
        fsel=collect("<results>/selector/fsel/seed{seed}.safetensors", seed=REFINED),
        lib=library(
            *FEATURES,
            "appearance",
            "baselines",
            "reconstruct",
            "report",
            "search",
            "sharpness",
            *FILES,
            "pipeline/policies",
            "pipeline/tables",
            "pipeline/timing",
        ),
    output:
        table=report(
            "<tables>/selection_time.tex",
            caption="../report/selection_time.rst",
            category="Tables",
            labels={"table": "Selection time", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/selection_time.csv",
            caption="../report/selection_time.rst",
            category="Tables",
            labels={"table": "Selection time", "form": "numbers"},
        ),
    log:
        "<results>/logs/selection_time.log",
    benchmark:
        "<results>/benchmarks/selection_time.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=60,
    params:
        pools=config["timing"]["pools"],
        k=config["timing"]["k"],
        targets=config["targets"],
        appearance=config["appearance"],
    message:
        "Timing every method on {TIMED}"
    script:
        "../scripts/selection_time.py"


rule speed:
    input:
        times="<tables>/selection_time.csv",
        evaluations=collect("<results>/{problem}/evaluation.parquet", problem=MEASURED),
        oracles=collect("<results>/{problem}/oracle.parquet", problem=MEASURED),
        lib=library(
            "baselines",
            "report",
            "pipeline/policies",
            "pipeline/tables",
            "pipeline/timing",
        ),
    output:
        report(
            multiext("<figures>/speed", ".pdf", ".png"),
            caption="../report/speed.rst",
            category="Speed",
            labels={"figure": "Selection time and PSNR behind the search"},
        ),
    log:
        "<results>/logs/speed.log",
    benchmark:
        "<results>/benchmarks/speed.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        problems=MEASURED,
        k=config["search"]["k"],
    message:
        "Drawing selection time against quality"
    script:
        "../scripts/speed.py"


rule fisher_damping:
    input:
        splits=collect("<results>/{problem}/split.parquet", problem=SWEPT),
        frames=[f"<results>/{d}/{s}/frames.parquet" for d, s in evaluation_scenes()],
        points=[f"<results>/{d}/{s}/points.parquet" for d, s in evaluation_scenes()],
        images=[f"<results>/{d}/{s}/images.npy" for d, s in evaluation_scenes()],
        descriptors=[
            f"<results>/{d}/{s}/descriptors.parquet" for d, s in evaluation_scenes()
        ],
        lib=library(
            *RECONSTRUCTION,
            "baselines",
            "problem",
            "report",
            "search",
            *FILES,
            "pipeline/damping",
            "pipeline/labels",
        ),
    output:
        table=report(
            "<tables>/fisher_damping.tex",
            caption="../report/fisher_damping.rst",
            category="Tables",
            labels={"table": "FisherRF's lambda", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/fisher_damping.csv",
            caption="../report/fisher_damping.rst",
            category="Tables",
            labels={"table": "FisherRF's lambda", "form": "numbers"},
        ),
    log:
        "<results>/logs/fisher_damping.log",
    benchmark:
        "<results>/benchmarks/fisher_damping.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        datasets=[dataset for dataset, _ in evaluation_scenes()],
        budgets=config["budgets"],
        reconstruction=config["reconstruction"],
    message:
        "Sweeping FisherRF's lambda"
    script:
        "../scripts/fisher_damping.py"
