"""The paper's other tables and figures. None is part of `rule all`; `paper` makes them all.

Inputs: evaluations, searches, labels, trained selectors and canonical captures.
Outputs: <tables>/{handsign,seedvar,ga_vs_learned,time_quality,crosscapture}.{tex,csv},
<figures>/{saturation,training,pipeline}.{pdf,png,csv},
<results>/{dataset}/{scene}/draw{draw}/{searched,geometry_picks,geometry}.parquet,
<results>/{dataset}/{scene}/{costs,times,crosscapture,crosscapture_picks}.parquet,
<results>/selector/geometry/seed{seed}.safetensors.
"""

WHOLE = {
    "datasets": labels(),
    "budgets": config["budgets"],
    "facts": facts(),
}
DRAWN = scenes(TRAINED, "train")[0]
CROSSED = sorted({budget_near(30), budget_near(40)})
CROSSING = {
    **{key: config["crosscapture"][key] for key in ("every", "targets")},
    "draws": config["draws"],
}


rule seedvar:
    input:
        evaluations=collect(
            "<results>/{problem}/evaluation.parquet",
            problem=evaluation_problems(config["draws"]),
        ),
        lib=library("seedvar"),
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
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        **WHOLE,
        problems=evaluation_problems(config["draws"]),
    message:
        "Writing how far training seeds spread"
    script:
        "../scripts/seedvar.py"


rule evaluate_searched:
    input:
        split="<results>/{dataset}/{scene}/draw{draw}/split.parquet",
        subsets="<results>/{dataset}/{scene}/draw{draw}/subsets.parquet",
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=library("evaluate_searched"),
    output:
        evaluation="<results>/{dataset}/{scene}/draw{draw}/searched.parquet",
    log:
        "<results>/logs/evaluate_searched/{dataset}/{scene}/draw{draw}.log",
    benchmark:
        "<results>/benchmarks/evaluate_searched/{dataset}/{scene}/draw{draw}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        reconstruction=config["reconstruction"],
    message:
        "Scoring the searched subsets of {wildcards.dataset}/{wildcards.scene} on the targets"
    script:
        "../scripts/evaluate_searched.py"


rule ga_vs_learned:
    input:
        evaluations=of_held_out("evaluation.parquet"),
        oracles=of_held_out("oracle.parquet"),
        searched=of_held_out("searched.parquet"),
        lib=library("ga_vs_learned"),
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
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        problems=lambda wildcards: held_out_problems(),
        k=config["search"]["k"],
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Comparing the selectors with the search"
    script:
        "../scripts/ga_vs_learned.py"


rule training_figure:
    input:
        logs=collect("<results>/selector/seed{seed}.parquet", seed=SEEDS),
        lib=library("training_figure"),
    output:
        figures=report(
            multiext("<figures>/training", ".pdf", ".png"),
            caption="../report/training.rst",
            category="Paper",
            labels={"figure": "Training"},
        ),
        numbers="<figures>/training.csv",
    log:
        "<results>/logs/training_figure.log",
    benchmark:
        "<results>/benchmarks/training_figure.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Drawing the training"
    script:
        "../scripts/training_figure.py"


rule pipeline_figure:
    input:
        frames=f"<results>/{TRAINED}/{DRAWN}/frames.parquet",
        images=f"<results>/{TRAINED}/{DRAWN}/images.npy",
        splits=f"<results>/labels/{DRAWN}/splits.parquet",
        labels=collect(
            f"<results>/labels/{DRAWN}/p{{coverage}}.parquet",
            coverage=config["coverages"],
        ),
        trajectories="<results>/trajectories.parquet",
        lib=library("pipeline_figure"),
    output:
        figures=report(
            multiext("<figures>/pipeline", ".pdf", ".png"),
            caption="../report/pipeline.rst",
            category="Paper",
            labels={"figure": "Search and labels"},
        ),
        numbers="<figures>/pipeline.csv",
    log:
        "<results>/logs/pipeline_figure.log",
    benchmark:
        "<results>/benchmarks/pipeline_figure.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(1000),
        runtime=per_capture(10),
    params:
        coverages=config["coverages"],
        scene=DRAWN,
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Drawing the search and the labels of {DRAWN}"
    script:
        "../scripts/pipeline_figure.py"


use rule select as select_geometry with:
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
        weights=collect(
            "<results>/selector/geometry/seed{seed}.safetensors", seed=SEEDS
        ),
        lib=library("select"),
    output:
        selections=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/geometry_picks.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/select_geometry/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_geometry/{dataset}/{scene}.jsonl"
    params:
        budgets=config["budgets"],
        seeds=lambda wildcards: [
            scene_seed(wildcards, "select", draw) for draw in range(config["draws"])
        ],
        # the whole candidate pool, as the paper's last row of time and quality
        methods=["all"],
        proxies_free=False,


use rule evaluate as evaluate_geometry with:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        selections=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/geometry_picks.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=library("evaluate"),
    output:
        evaluations=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/geometry.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/evaluate_geometry/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_geometry/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(180),
        gpu=GPU,
    params:
        reconstruction=config["reconstruction"],
        metrics=METRICS,


rule measure_costs:
    input:
        split="<results>/{dataset}/{scene}/draw0/split.parquet",
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=[
            "<results>/selector/seed0.safetensors",
            "<results>/selector/no_appearance/seed0.safetensors",
            "<results>/selector/geometry/seed0.safetensors",
        ],
        lib=library("measure_costs"),
    output:
        costs="<results>/{dataset}/{scene}/costs.parquet",
        times="<results>/{dataset}/{scene}/times.parquet",
    log:
        "<results>/logs/measure_costs/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/measure_costs/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(30),
        gpu=GPU,
    params:
        budgets=config["budgets"],
        appearance=config["appearance"],
        reconstruction=config["reconstruction"],
    message:
        "Measuring time and memory on {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/measure_costs.py"


rule saturation:
    input:
        costs=of_held_out_scenes("costs.parquet"),
        lib=library("saturation"),
    output:
        figures=report(
            multiext("<figures>/saturation", ".pdf", ".png"),
            caption="../report/saturation.rst",
            category="Paper",
            labels={"figure": "Quality, time, memory against K"},
        ),
        numbers="<figures>/saturation.csv",
    log:
        "<results>/logs/saturation.log",
    benchmark:
        "<results>/benchmarks/saturation.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Drawing quality, time and memory against the number of frames"
    script:
        "../scripts/saturation.py"


rule time_quality:
    input:
        evaluations=of_held_out_scenes("evaluation.parquet", range(config["draws"])),
        variant=of_held_out_scenes("geometry.parquet", range(config["draws"])),
        costs=of_held_out_scenes("costs.parquet"),
        times=of_held_out_scenes("times.parquet"),
        lib=library("time_quality"),
    output:
        table=report(
            "<tables>/time_quality.tex",
            caption="../report/time_quality.rst",
            category="Paper",
            labels={"table": "Quality, runtime and memory", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/time_quality.csv",
            caption="../report/time_quality.rst",
            category="Paper",
            labels={"table": "Quality, runtime and memory", "form": "numbers"},
        ),
    log:
        "<results>/logs/time_quality.log",
    benchmark:
        "<results>/benchmarks/time_quality.jsonl"
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
            for n in range(config["draws"])
        ],
        budgets=config["budgets"],
        facts=lambda wildcards: facts([TRAINED]),
    message:
        "Writing quality, runtime and memory"
    script:
        "../scripts/time_quality.py"


rule select_crosscapture:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=SCORERS,
        lib=library("select_crosscapture"),
    output:
        picks="<results>/{dataset}/{scene}/crosscapture_picks.parquet",
    log:
        "<results>/logs/select_crosscapture/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_crosscapture/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
    params:
        **CROSSING,
        held_out=passes,
        budgets=CROSSED,
        seed=lambda wildcards: scene_seed(wildcards, "crosscapture"),
    message:
        "Selecting with each pass of {wildcards.dataset}/{wildcards.scene} held out"
    script:
        "../scripts/select_crosscapture.py"


rule evaluate_crosscapture:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/crosscapture_picks.parquet",
        lib=library("evaluate_crosscapture"),
    output:
        evaluation="<results>/{dataset}/{scene}/crosscapture.parquet",
    log:
        "<results>/logs/evaluate_crosscapture/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_crosscapture/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        **CROSSING,
        held_out=passes,
        seed=lambda wildcards: scene_seed(wildcards, "crosscapture"),
        reconstruction=config["reconstruction"],
        metrics=METRICS,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} with each pass held out"
    script:
        "../scripts/evaluate_crosscapture.py"


rule crosscapture:
    input:
        evaluations=of_rooms("crosscapture.parquet"),
        lib=library("crosscapture"),
    output:
        table=report(
            "<tables>/crosscapture.tex",
            caption="../report/crosscapture.rst",
            category="Paper",
            labels={"table": "Cross-capture", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/crosscapture.csv",
            caption="../report/crosscapture.rst",
            category="Paper",
            labels={"table": "Cross-capture", "form": "numbers"},
        ),
    log:
        "<results>/logs/crosscapture.log",
    benchmark:
        "<results>/benchmarks/crosscapture.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=lambda wildcards: rooms(),
        budgets=CROSSED,
        metrics=METRICS,
        facts=lambda wildcards: facts(list(dict(rooms()))),
    message:
        "Writing the cross-capture table"
    script:
        "../scripts/crosscapture.py"
