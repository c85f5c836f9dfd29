"""The paper's other tables under the further reconstructors, from the same picks. When asked for.

Inputs: problems and picks.
Outputs: <results>/{dataset}/{scene}/{judge}/{costs,times,crosscapture,objects}.parquet,
<results>/{dataset}/{scene}/draw{draw}/{judge}/geometry.parquet,
<tables>/{judge}/{time_quality,crosscapture,objectcentric}.{tex,csv},
<figures>/{judge}/saturation.{pdf,png,csv}.
"""


use rule evaluate_geometry as evaluate_geometry_further with:
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
        lib=lambda wildcards: library("evaluate", judge_of(wildcards)["name"]),
    output:
        evaluations=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/{{judge}}/geometry.parquet",
            draw=range(config["draws"]),
        ),
    log:
        "<results>/logs/evaluate_geometry/{judge}/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_geometry/{judge}/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(180),
        gpu=lambda wildcards: int(needs_gpu(judge_of(wildcards))),
    params:
        reconstruction=judge_of,
        metrics=METRICS,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} by {wildcards.judge}"


use rule measure_costs as measure_costs_further with:
    input:
        split="<results>/{dataset}/{scene}/draw0/split.parquet",
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=rules.measure_costs.input.weights,
        lib=lambda wildcards: library("measure_costs", judge_of(wildcards)["name"]),
    output:
        costs="<results>/{dataset}/{scene}/{judge}/costs.parquet",
        times="<results>/{dataset}/{scene}/{judge}/times.parquet",
    log:
        "<results>/logs/measure_costs/{judge}/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/measure_costs/{judge}/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(180),
        gpu=lambda wildcards: int(needs_gpu(judge_of(wildcards))),
    params:
        budgets=config["budgets"],
        appearance=config["appearance"],
        reconstruction=judge_of,
    message:
        "Measuring time and memory on {wildcards.dataset}/{wildcards.scene} by {wildcards.judge}"


use rule evaluate_crosscapture as evaluate_crosscapture_further with:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/crosscapture_picks.parquet",
        lib=lambda wildcards: library(
            "evaluate_crosscapture", judge_of(wildcards)["name"]
        ),
    output:
        evaluation="<results>/{dataset}/{scene}/{judge}/crosscapture.parquet",
    log:
        "<results>/logs/evaluate_crosscapture/{judge}/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_crosscapture/{judge}/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(180),
        gpu=lambda wildcards: int(needs_gpu(judge_of(wildcards))),
    params:
        **CROSSING,
        held_out=passes,
        seed=lambda wildcards: scene_seed(wildcards, "crosscapture"),
        reconstruction=judge_of,
        metrics=METRICS,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} with each pass held out by {wildcards.judge}"


use rule evaluate_objects as evaluate_objects_further with:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        masks="<results>/{dataset}/{scene}/masks.npy",
        picks="<results>/{dataset}/{scene}/objects_picks.parquet",
        lib=lambda wildcards: library("evaluate_objects", judge_of(wildcards)["name"]),
    output:
        evaluation="<results>/{dataset}/{scene}/{judge}/objects.parquet",
    log:
        "<results>/logs/evaluate_objects/{judge}/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_objects/{judge}/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(180),
        gpu=lambda wildcards: int(needs_gpu(judge_of(wildcards))),
    params:
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "objects"),
        reconstruction=judge_of,
        metrics=METRICS,
    message:
        "Reconstructing the object of {wildcards.dataset}/{wildcards.scene} by {wildcards.judge}"


use rule saturation as saturation_further with:
    input:
        costs=by_judge(of_held_out_scenes("costs.parquet")),
        lib=library("saturation"),
    output:
        figures=report(
            multiext("<figures>/{judge}/saturation", ".pdf", ".png"),
            caption="../report/saturation.rst",
            category="Paper",
            labels={"figure": "Quality, time, memory against K, {judge}"},
        ),
        numbers="<figures>/{judge}/saturation.csv",
    log:
        "<results>/logs/saturation/{judge}.log",
    benchmark:
        "<results>/benchmarks/saturation/{judge}.jsonl"
    params:
        facts=lambda wildcards: judge_facts(wildcards, [TRAINED]),
    message:
        "Drawing quality, time and memory against the number of frames by {wildcards.judge}"


use rule time_quality as time_quality_further with:
    input:
        evaluations=by_judge(
            of_held_out_scenes("evaluation.parquet", range(config["draws"]))
        ),
        variant=by_judge(of_held_out_scenes("geometry.parquet", range(config["draws"]))),
        costs=by_judge(of_held_out_scenes("costs.parquet")),
        times=by_judge(of_held_out_scenes("times.parquet")),
        lib=library("time_quality"),
    output:
        table=report(
            "<tables>/{judge}/time_quality.tex",
            caption="../report/time_quality.rst",
            category="Paper",
            labels={"table": "Quality, runtime and memory, {judge}", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/{judge}/time_quality.csv",
            caption="../report/time_quality.rst",
            category="Paper",
            labels={
                "table": "Quality, runtime and memory, {judge}",
                "form": "numbers",
            },
        ),
    log:
        "<results>/logs/time_quality/{judge}.log",
    benchmark:
        "<results>/benchmarks/time_quality/{judge}.jsonl"
    params:
        problems=lambda wildcards: [
            f"{TRAINED}/{scene}/draw{n}"
            for scene in held_out_scenes()
            for n in range(config["draws"])
        ],
        budgets=config["budgets"],
        facts=lambda wildcards: judge_facts(wildcards, [TRAINED]),
    message:
        "Writing quality, runtime and memory by {wildcards.judge}"


use rule crosscapture as crosscapture_further with:
    input:
        evaluations=by_judge(of_rooms("crosscapture.parquet")),
        lib=library("crosscapture"),
    output:
        table=report(
            "<tables>/{judge}/crosscapture.tex",
            caption="../report/crosscapture.rst",
            category="Paper",
            labels={"table": "Cross-capture, {judge}", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/{judge}/crosscapture.csv",
            caption="../report/crosscapture.rst",
            category="Paper",
            labels={"table": "Cross-capture, {judge}", "form": "numbers"},
        ),
    log:
        "<results>/logs/crosscapture/{judge}.log",
    benchmark:
        "<results>/benchmarks/crosscapture/{judge}.jsonl"
    params:
        scenes=lambda wildcards: rooms(),
        budgets=CROSSED,
        metrics=METRICS,
        facts=lambda wildcards: judge_facts(wildcards, list(dict(rooms()))),
    message:
        "Writing the cross-capture table by {wildcards.judge}"


use rule objectcentric as objectcentric_further with:
    input:
        evaluations=by_judge(of_objects("objects.parquet")),
        lib=library("objectcentric"),
    output:
        table=report(
            "<tables>/{judge}/objectcentric.tex",
            caption="../report/objectcentric.rst",
            category="Paper",
            labels={"table": "Object-centric, {judge}", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/{judge}/objectcentric.csv",
            caption="../report/objectcentric.rst",
            category="Paper",
            labels={"table": "Object-centric, {judge}", "form": "numbers"},
        ),
    log:
        "<results>/logs/objectcentric/{judge}.log",
    benchmark:
        "<results>/benchmarks/objectcentric/{judge}.jsonl"
    params:
        scenes=lambda wildcards: object_scenes(),
        datasets=lambda wildcards: {
            name: config["datasets"][name]["label"] for name in dict(object_scenes())
        },
        metrics=METRICS,
        facts=lambda wildcards: judge_facts(wildcards, list(dict(object_scenes()))),
    message:
        "Writing the object-centric table by {wildcards.judge}"
