"""What swaps of picks gain against the seconds they take (not in the paper).

evaluate_swaps: <results>/{dataset}/{scene}/swaps.parquet, of the first draw, at the search's budget.
swaps: <figures>/swaps.{pdf,png}, <tables>/swaps.csv.
"""


rule evaluate_swaps:
    input:
        split="<results>/{dataset}/{scene}/draw0/split.parquet",
        selections="<results>/{dataset}/{scene}/draw0/selections.parquet",
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        lib=library("evaluate_swaps", config["reconstruction"]["name"]),
    output:
        evaluation="<results>/{dataset}/{scene}/swaps.parquet",
    log:
        "<results>/logs/evaluate_swaps/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_swaps/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(30),
        gpu=GPU,
    params:
        reconstruction=config["reconstruction"],
        k=config["search"]["k"],
        seed=lambda wildcards: scene_seed(wildcards, "swaps"),
    message:
        "Swapping picks of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/evaluate_swaps.py"


rule swaps:
    input:
        evaluations=lambda wildcards: [
            f"<results>/{dataset}/{scene}/swaps.parquet"
            for dataset, scene in evaluation_scenes()
        ],
        lib=library("swaps"),
    output:
        figures=report(
            multiext("<figures>/swaps", ".pdf", ".png"),
            caption="../report/swaps.rst",
            category="Speed",
            labels={"figure": "Gain of swaps against seconds"},
        ),
        numbers="<tables>/swaps.csv",
    log:
        "<results>/logs/swaps.log",
    benchmark:
        "<results>/benchmarks/swaps.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        k=config["search"]["k"],
        facts=facts(),
    message:
        "Drawing what swaps gain"
    script:
        "../scripts/swaps.py"
