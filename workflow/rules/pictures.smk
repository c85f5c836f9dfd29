"""Figures of rendered views, by the reconstructor of `pictures`. Part of `paper` alone.

Inputs: problems, picks and evaluations; embedded scenes are filmed anew with larger images.
Outputs: <results>/{dataset}/{scene}/pictures/ (canonical captures),
<figures>/{teaser,real_world,qualitative_{dataset}}.{pdf,png,csv}.
"""

VIEWED = ("all", "uniform", "strongest", "less_is_more", "fsel")


use rule generate as generate_pictures with:
    output:
        folder=directory("<results>/{dataset}/{scene}/pictures/data"),
    log:
        "<results>/logs/generate_pictures/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/generate_pictures/{dataset}/{scene}.jsonl"
    params:
        frames=config["embedded"]["frames"],
        width=filmed_size()[0],
        height=filmed_size()[1],
        layout=lambda wildcards: config["datasets"][wildcards.dataset]["layout"],
        family=lambda wildcards: config["datasets"][wildcards.dataset]["embedded"][
            "family"
        ],
        seed=lambda wildcards: scene_seed(wildcards),
    message:
        "Generating {wildcards.dataset}/{wildcards.scene} with images for pictures"


use rule ingest as ingest_pictures with:
    input:
        source=pictured_capture,
        lib=library("ingest"),
    output:
        frames="<results>/{dataset}/{scene}/pictures/frames.parquet",
        points="<results>/{dataset}/{scene}/pictures/points.parquet",
        images="<results>/{dataset}/{scene}/pictures/images.npy",
    log:
        "<results>/logs/ingest_pictures/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/ingest_pictures/{dataset}/{scene}.jsonl"
    params:
        reading=lambda wildcards: reading(wildcards.dataset, wildcards.scene),
        long_side=PICTURES["long_side"],
        at_least=lambda wildcards: frames_needed(
            role_of(wildcards.dataset, wildcards.scene)
        ),
    message:
        "Reading {wildcards.dataset}/{wildcards.scene} with images for pictures"


rule qualitative:
    input:
        frames=first_scene("pictures/frames.parquet"),
        points=first_scene("pictures/points.parquet"),
        images=first_scene("pictures/images.npy"),
        split=first_scene("draw0/split.parquet"),
        selections=first_scene("draw0/selections.parquet"),
        evaluations=lambda wildcards: [
            first_scene(f"draw{n}/evaluation.parquet")(wildcards)
            for n in range(config["draws"])
        ],
        lib=library("qualitative", PICTURES["name"]),
    output:
        figures=report(
            multiext("<figures>/qualitative_{dataset}", ".pdf", ".png"),
            caption="../report/qualitative.rst",
            category="Paper",
            labels={"figure": "Views on {dataset}"},
        ),
        numbers="<figures>/qualitative_{dataset}.csv",
    log:
        "<results>/logs/qualitative/{dataset}.log",
    benchmark:
        "<results>/benchmarks/qualitative/{dataset}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
        gpu=lambda wildcards: int(needs_gpu(pictured())),
    params:
        methods=VIEWED,
        views=3,
        k=budget_near(40),
        reconstruction=lambda wildcards: pictured(),
        facts=lambda wildcards: pictured_facts([wildcards.dataset]),
    message:
        "Drawing views of {wildcards.dataset}"
    script:
        "../scripts/qualitative.py"


use rule qualitative as teaser with:
    input:
        frames=f"<results>/{TIMED}/pictures/frames.parquet",
        points=f"<results>/{TIMED}/pictures/points.parquet",
        images=f"<results>/{TIMED}/pictures/images.npy",
        split=f"<results>/{TIMED}/draw0/split.parquet",
        selections=f"<results>/{TIMED}/draw0/selections.parquet",
        evaluations=collect(
            f"<results>/{TIMED}/draw{{n}}/evaluation.parquet", n=range(config["draws"])
        ),
        lib=library("qualitative", PICTURES["name"]),
    output:
        figures=report(
            multiext("<figures>/teaser", ".pdf", ".png"),
            caption="../report/qualitative.rst",
            category="Paper",
            labels={"figure": "Full sequence, Uniform, ours"},
        ),
        numbers="<figures>/teaser.csv",
    log:
        "<results>/logs/teaser.log",
    benchmark:
        "<results>/benchmarks/teaser.jsonl"
    params:
        methods=VIEWED,
        views=1,
        k=budget_near(30),
        reconstruction=lambda wildcards: pictured(),
        facts=pictured_facts([TIMED.split("/")[0]]),
    message:
        "Drawing the full sequence, Uniform and ours"


rule real_world:
    input:
        frames=first_place("pictures/frames.parquet"),
        points=first_place("pictures/points.parquet"),
        images=first_place("pictures/images.npy"),
        selected_from=first_place("frames.parquet"),
        picks=first_place("crosscapture_picks.parquet"),
        evaluation=first_place("crosscapture.parquet"),
        lib=library("real_world", PICTURES["name"]),
    output:
        figures=report(
            multiext("<figures>/real_world", ".pdf", ".png"),
            caption="../report/real_world.rst",
            category="Paper",
            labels={"figure": "One capture from others of the place"},
        ),
        numbers="<figures>/real_world.csv",
    log:
        "<results>/logs/real_world.log",
    benchmark:
        "<results>/benchmarks/real_world.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
        gpu=lambda wildcards: int(needs_gpu(pictured())),
    params:
        methods=VIEWED,
        views=3,
        k=max(CROSSED),
        reconstruction=lambda wildcards: pictured(),
        facts=lambda wildcards: pictured_facts([rooms()[0][0]]),
    message:
        "Drawing views of one capture, reconstructed from others of the place"
    script:
        "../scripts/real_world.py"
