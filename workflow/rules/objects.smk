"""One object of a capture: masks beside the images, and the object-centric table.

Inputs: captures with masks, trained selectors.
Outputs: <results>/{dataset}/{scene}/masks.npy, <results>/{dataset}/{scene}/{objects_picks,objects}.parquet,
<tables>/objectcentric.{tex,csv}.
"""


rule select_objects:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        masks="<results>/{dataset}/{scene}/masks.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=[
            *OURS,
            *FSEL,
        ],
        lib=library("select_objects"),
    output:
        picks="<results>/{dataset}/{scene}/objects_picks.parquet",
    log:
        "<results>/logs/select_objects/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_objects/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        k=budget_near(30),
        draws=config["draws"],
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "objects"),
        reconstruction=config["reconstruction"],
    message:
        "Selecting views of the object of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/select_objects.py"


rule evaluate_objects:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        masks="<results>/{dataset}/{scene}/masks.npy",
        picks="<results>/{dataset}/{scene}/objects_picks.parquet",
        lib=library("evaluate_objects"),
    output:
        evaluation="<results>/{dataset}/{scene}/objects.parquet",
    log:
        "<results>/logs/evaluate_objects/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_objects/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        targets=config["targets"],
        seed=lambda wildcards: scene_seed(wildcards, "objects"),
        reconstruction=config["reconstruction"],
        metrics=METRICS,
    message:
        "Reconstructing the object of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/evaluate_objects.py"


rule objectcentric:
    input:
        evaluations=of_objects("objects.parquet"),
        lib=library("objectcentric"),
    output:
        table=report(
            "<tables>/objectcentric.tex",
            caption="../report/objectcentric.rst",
            category="Paper",
            labels={"table": "Object-centric", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/objectcentric.csv",
            caption="../report/objectcentric.rst",
            category="Paper",
            labels={"table": "Object-centric", "form": "numbers"},
        ),
    log:
        "<results>/logs/objectcentric.log",
    benchmark:
        "<results>/benchmarks/objectcentric.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=lambda wildcards: object_scenes(),
        datasets=lambda wildcards: {
            name: config["datasets"][name]["label"] for name in dict(object_scenes())
        },
        metrics=METRICS,
        facts=lambda wildcards: facts(list(dict(object_scenes()))),
    message:
        "Writing the object-centric table"
    script:
        "../scripts/objectcentric.py"
