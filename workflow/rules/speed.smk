"""What selection costs, beside what it is worth.

Inputs: a canonical capture, problems, trained selectors and their evaluations.
Outputs: <tables>/{selection_time,speed_error,economy}.{tex,csv},
<figures>/speed_error.{pdf,png}, <results>/speed_settings.csv.
"""

TIMED = "/".join(evaluation_scenes()[0])
SWEPT = evaluation_problems(1)


rule selection_time:
    input:
        frames=f"<results>/{TIMED}/frames.parquet",
        points=f"<results>/{TIMED}/points.parquet",
        images=f"<results>/{TIMED}/images.npy",
        weights=SCORERS,
        lib=library("selection_time"),
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
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
    params:
        pools=config["timing"]["pools"],
        k=config["timing"]["k"],
        targets=config["targets"],
        appearance=config["appearance"],
    message:
        "Timing every method on {TIMED}"
    script:
        "../scripts/selection_time.py"


rule speed_settings:
    input:
        splits=collect("<results>/{problem}/split.parquet", problem=SWEPT),
        frames=[f"<results>/{d}/{s}/frames.parquet" for d, s in evaluation_scenes()],
        points=[f"<results>/{d}/{s}/points.parquet" for d, s in evaluation_scenes()],
        images=[f"<results>/{d}/{s}/images.npy" for d, s in evaluation_scenes()],
        descriptors=[
            f"<results>/{d}/{s}/descriptors.parquet" for d, s in evaluation_scenes()
        ],
        lib=library("speed_settings"),
    output:
        numbers="<results>/speed_settings.csv",
    log:
        "<results>/logs/speed_settings.log",
    benchmark:
        "<results>/benchmarks/speed_settings.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        generated=[generated(*scene) for scene in evaluation_scenes()],
        k=config["search"]["k"],
        reconstruction=config["reconstruction"],
    message:
        "Measuring the reconstructor's settings"
    script:
        "../scripts/speed_settings.py"


rule economy:
    input:
        splits=collect("<results>/{problem}/split.parquet", problem=SWEPT),
        frames=[f"<results>/{d}/{s}/frames.parquet" for d, s in evaluation_scenes()],
        points=[f"<results>/{d}/{s}/points.parquet" for d, s in evaluation_scenes()],
        images=[f"<results>/{d}/{s}/images.npy" for d, s in evaluation_scenes()],
        descriptors=[
            f"<results>/{d}/{s}/descriptors.parquet" for d, s in evaluation_scenes()
        ],
        lib=library("economy"),
    output:
        table=report(
            "<tables>/economy.tex",
            caption="../report/economy.rst",
            category="Speed",
            labels={"table": "Modelling only what a scene needs", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/economy.csv",
            caption="../report/economy.rst",
            category="Speed",
            labels={"table": "Modelling only what a scene needs", "form": "numbers"},
        ),
    log:
        "<results>/logs/economy.log",
    benchmark:
        "<results>/benchmarks/economy.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        generated=[generated(*scene) for scene in evaluation_scenes()],
        k=config["search"]["k"],
        reconstruction=config["reconstruction"],
        appearance=config["appearance"],
    message:
        "Switching off each saving in turn"
    script:
        "../scripts/economy.py"


rule speed_error:
    input:
        times="<tables>/selection_time.csv",
        settings="<results>/speed_settings.csv",
        evaluations=of_held_out("evaluation.parquet"),
        oracles=of_held_out("oracle.parquet"),
        subsets=of_held_out("subsets.parquet"),
        labels=collect(
            "<results>/labels/{scene}/p{coverage}.parquet",
            scene=LABELLED,
            coverage=config["coverages"],
        ),
        lib=library("speed_error"),
    output:
        table=report(
            "<tables>/speed_error.tex",
            caption="../report/speed_error.rst",
            category="Speed",
            labels={"table": "Speed against error", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/speed_error.csv",
            caption="../report/speed_error.rst",
            category="Speed",
            labels={"table": "Speed against error", "form": "numbers"},
        ),
        figures=report(
            multiext("<figures>/speed_error", ".pdf", ".png"),
            caption="../report/speed_error.rst",
            category="Speed",
            labels={"figure": "Speed against error"},
        ),
    log:
        "<results>/logs/speed_error.log",
    benchmark:
        "<results>/benchmarks/speed_error.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        problems=lambda wildcards: held_out_problems(),
        k=config["search"]["k"],
    message:
        "Drawing speed against error"
    script:
        "../scripts/speed_error.py"
