"""Labels for requests, and what is learned from them (not in the paper, not part of `rule all`).

Requests: subsets of all observed frames, judged on the views to be rendered; `learning_labels`.
Inputs: canonical captures of the first train scenes of every dataset; problems of other scenes.
Outputs: <results>/{dataset}/{scene}/{requests,request_splits}.parquet,
<results>/learning/{learner}.{safetensors,parquet}, <results>/learning/inputs/networks.*,
<results>/{dataset}/{scene}/learning/{learned,inputs}{_picks,}.parquet,
<tables>/{learning,inputs}.{tex,csv}.
"""

LEARNING = config["learning"]


rule label_requests:
    input:
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        lib=library("label_requests", LABELLED_BY["name"]),
    output:
        labels="<results>/{dataset}/{scene}/requests.parquet",
        splits="<results>/{dataset}/{scene}/request_splits.parquet",
    log:
        "<results>/logs/label_requests/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/label_requests/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=int(needs_gpu(LABELLED_BY)),
    params:
        **{key: LEARNING[key] for key in ("coverages", "draws", "budgets", "search")},
        reconstruction=LABELLED_BY,
        seed=lambda wildcards: scene_seed(wildcards, "requests"),
    message:
        "Searching for good subsets of requests of {wildcards.dataset}/{wildcards.scene}"
    script:
        "../scripts/label_requests.py"


rule learning_labels:
    input:
        lambda wildcards: labelled_requests(),
    localrule: True


wildcard_constraints:
    learner="|".join(LEARNERS),


rule learn:
    input:
        frames=collect("<results>/{scene}/frames.parquet", scene=LESSONS),
        points=collect("<results>/{scene}/points.parquet", scene=LESSONS),
        images=collect("<results>/{scene}/images.npy", scene=LESSONS),
        descriptors=collect("<results>/{scene}/descriptors.parquet", scene=LESSONS),
        labels=lambda wildcards: labelled_requests(),
        splits=collect("<results>/{scene}/request_splits.parquet", scene=LESSONS),
        start=lambda wildcards: started_from(wildcards),
        lib=library("learn", LABELLED_BY["name"]),
    output:
        networks="<results>/learning/{learner}.safetensors",
        log="<results>/learning/{learner}.parquet",
    log:
        "<results>/logs/learn/{learner}.log",
    benchmark:
        "<results>/benchmarks/learn/{learner}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(8000),
        runtime=per_reconstruction(240),
        gpu=int(needs_gpu(LABELLED_BY)),
    params:
        settings=LEARNING["training"]
        | LEARNING["practice"]
        | {"learning_rate": config["training"]["learning_rate"]},
        practised=first_lessons(),
        reconstruction=LABELLED_BY,
    message:
        "Learning: {wildcards.learner}"
    script:
        "../scripts/learn.py"


rule learn_inputs:
    input:
        frames=collect("<results>/{scene}/frames.parquet", scene=LESSONS),
        images=collect("<results>/{scene}/images.npy", scene=LESSONS),
        descriptors=collect("<results>/{scene}/descriptors.parquet", scene=LESSONS),
        labels=lambda wildcards: labelled_requests(),
        splits=collect("<results>/{scene}/request_splits.parquet", scene=LESSONS),
        lib=library("learn_inputs"),
    output:
        networks="<results>/learning/inputs/networks.safetensors",
        log="<results>/learning/inputs/networks.parquet",
    log:
        "<results>/logs/learn_inputs.log",
    benchmark:
        "<results>/benchmarks/learn_inputs.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(8000),
        runtime=growing(240),
    params:
        settings=LEARNING["training"]
        | {"learning_rate": config["training"]["learning_rate"]},
    message:
        "Learning from every set of inputs"
    script:
        "../scripts/learn_inputs.py"


rule select_learned:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        networks=collect("<results>/learning/{learner}.safetensors", learner=LEARNERS),
        lib=library("select_learned"),
    output:
        picks="<results>/{dataset}/{scene}/learning/learned_picks.parquet",
    log:
        "<results>/logs/select_learned/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_learned/{dataset}/{scene}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_capture(4000),
        runtime=per_capture(60),
    params:
        budgets=config["budgets"],
    message:
        "Selecting frames of {wildcards.dataset}/{wildcards.scene} by learned networks"
    script:
        "../scripts/select_learned.py"


rule evaluate_learned:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        picks="<results>/{dataset}/{scene}/learning/{of}_picks.parquet",
        lib=library("evaluate_learned"),
    output:
        evaluation="<results>/{dataset}/{scene}/learning/{of}.parquet",
    log:
        "<results>/logs/evaluate_learned/{dataset}/{scene}/{of}.log",
    benchmark:
        "<results>/benchmarks/evaluate_learned/{dataset}/{scene}/{of}.jsonl"
    wildcard_constraints:
        of="learned|inputs",
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=GPU,
    params:
        reconstruction=config["reconstruction"],
        budgets=config["budgets"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} from the picks of learned networks"
    script:
        "../scripts/evaluate_learned.py"


use rule select_learned as select_inputs with:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        networks=["<results>/learning/inputs/networks.safetensors"],
        lib=library("select_learned"),
    output:
        picks="<results>/{dataset}/{scene}/learning/inputs_picks.parquet",
    log:
        "<results>/logs/select_inputs/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_inputs/{dataset}/{scene}.jsonl"
    message:
        "Selecting frames of {wildcards.dataset}/{wildcards.scene} by networks of every set of inputs"


rule learning:
    input:
        evaluations=lambda wildcards: [
            f"<results>/{d}/{s}/learning/learned.parquet"
            for _, d, s in judged_scenes()
        ],
        logs=collect("<results>/learning/{learner}.parquet", learner=LEARNERS),
        lib=library("learning"),
    output:
        table=report(
            "<tables>/learning.tex",
            caption="../report/learning.rst",
            category="Learning",
            labels={"table": "Ways to learn", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/learning.csv",
            caption="../report/learning.rst",
            category="Learning",
            labels={"table": "Ways to learn", "form": "numbers"},
        ),
    log:
        "<results>/logs/learning.log",
    benchmark:
        "<results>/benchmarks/learning.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=lambda wildcards: judged_scenes(),
        learners=list(LEARNERS),
        facts=lambda wildcards: facts(judged_datasets()),
    message:
        "Writing what ways to learn are worth"
    script:
        "../scripts/learning.py"


rule inputs:
    input:
        evaluations=lambda wildcards: [
            f"<results>/{d}/{s}/learning/inputs.parquet"
            for _, d, s in validation_scenes()
        ],
        again=lambda wildcards: [
            f"<results>/{d}/{s}/learning/inputs_again.parquet"
            for _, d, s in validation_scenes()
        ],
        log="<results>/learning/inputs/networks.parquet",
        lib=library("inputs"),
    output:
        table=report(
            "<tables>/inputs.tex",
            caption="../report/inputs.rst",
            category="Learning",
            labels={"table": "Inputs", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/inputs.csv",
            caption="../report/inputs.rst",
            category="Learning",
            labels={"table": "Inputs", "form": "numbers"},
        ),
    log:
        "<results>/logs/inputs.log",
    benchmark:
        "<results>/benchmarks/inputs.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        scenes=lambda wildcards: validation_scenes(),
        judges=lambda wildcards: {
            name: judged_by(name, section)
            for name, section in learning_judges().items()
        },
        facts=lambda wildcards: facts(judged_datasets(["validation"])),
    message:
        "Writing what groups of inputs are worth"
    script:
        "../scripts/inputs.py"
