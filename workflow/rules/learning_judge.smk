"""Labels of requests, and picks of networks, under a second judge (not in the paper).

Inputs: labelled requests of the first train scene of every dataset; picks on validation scenes.
Outputs: <results>/{dataset}/{scene}/requests_again.parquet,
<results>/{dataset}/{scene}/learning/inputs_again.parquet, <tables>/judges_rank.{tex,csv}.
"""

SECOND_DRAWS = range(min(config["draws"], LEARNING["judge"]["draws"]))


rule judge_requests:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        labels="<results>/{dataset}/{scene}/requests.parquet",
        splits="<results>/{dataset}/{scene}/request_splits.parquet",
        lib=lambda wildcards: library("judge_requests", second_judge()[1]["name"]),
    output:
        judged="<results>/{dataset}/{scene}/requests_again.parquet",
    log:
        "<results>/logs/judge_requests/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/judge_requests/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=lambda wildcards: int(needs_gpu(second_judge()[1])),
    params:
        reconstruction=lambda wildcards: second_judge()[1],
        subsets=LEARNING["judge"]["subsets"],
    message:
        "Judging labelled subsets of {wildcards.dataset}/{wildcards.scene} again"
    script:
        "../scripts/judge_requests.py"


use rule evaluate_learned as evaluate_inputs_again with:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=SECOND_DRAWS,
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/learning/inputs_picks.parquet",
        lib=lambda wildcards: library("evaluate_learned", second_judge()[1]["name"]),
    output:
        evaluation="<results>/{dataset}/{scene}/learning/inputs_again.parquet",
    log:
        "<results>/logs/evaluate_inputs_again/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/evaluate_inputs_again/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=lambda wildcards: int(needs_gpu(second_judge()[1])),
    params:
        reconstruction=lambda wildcards: second_judge()[1],
        budgets=lambda wildcards: second_budgets(),
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} by a second judge, from picks of networks"


rule judges_rank:
    input:
        judged=lambda wildcards: [
            f"<results>/{scene}/requests_again.parquet" for scene in first_labelled()
        ],
        lib=library("judges_rank"),
    output:
        table=report(
            "<tables>/judges_rank.tex",
            caption="../report/judges_rank.rst",
            category="Learning",
            labels={"table": "Two judges", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/judges_rank.csv",
            caption="../report/judges_rank.rst",
            category="Learning",
            labels={"table": "Two judges", "form": "numbers"},
        ),
    log:
        "<results>/logs/judges_rank.log",
    benchmark:
        "<results>/benchmarks/judges_rank.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=first_labelled(),
        labeller=judged_by(LABELLED_BY["name"], LABELLED_BY),
        judge=lambda wildcards: judged_by(*second_judge()),
        facts=facts(list(dict.fromkeys(scene.split("/")[0] for scene in LESSONS))),
    message:
        "Writing how well two judges rank the same subsets"
    script:
        "../scripts/judges_rank.py"
