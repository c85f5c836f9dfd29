"""The paper's scorer with other features, and other scorers, on the scenes of `trials`.

Inputs: trajectories, canonical captures of the training dataset and of all validation scenes.
Outputs: <results>/trials/{table}/{trial}.parquet, <results>/{dataset}/{scene}/{table}.parquet,
<tables>/{feature_sweep,scorer_arch}.{tex,csv}.
"""


wildcard_constraints:
    table="feature_sweep|scorer_arch",
    trial=r"\w+",


rule trial:
    input:
        trajectories="<results>/trajectories.parquet",
        frames=collect(f"<results>/{TRAINED}/{{scene}}/frames.parquet", scene=LABELLED),
        descriptors=collect(
            f"<results>/{TRAINED}/{{scene}}/descriptors.parquet", scene=LABELLED
        ),
        splits=collect("<results>/labels/{scene}/splits.parquet", scene=LABELLED),
        validation_frames=of_trial_scenes("frames.parquet"),
        validation_descriptors=of_trial_scenes("descriptors.parquet"),
        validation_splits=of_trial_scenes("split.parquet", range(config["draws"])),
        lib=library("trial"),
    output:
        picks="<results>/trials/{table}/{trial}.parquet",
    log:
        "<results>/logs/trial/{table}/{trial}.log",
    benchmark:
        "<results>/benchmarks/trial/{table}/{trial}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(4000),
        runtime=growing(120),
    params:
        case=lambda wildcards: cases(wildcards.table)[wildcards.trial],
        k=lambda wildcards: trial_budget(wildcards.table),
        scenes=list(LABELLED),
        problems=lambda wildcards: [
            f"{d}/{s}/draw{n}"
            for d, s in trial_scenes(wildcards.table)
            for n in range(config["draws"])
        ],
        learning_rate=config["training"]["learning_rate"],
        seeds=config["trials"]["seeds"],
        epochs=config["trials"]["epochs"],
    message:
        "Training {wildcards.table} {wildcards.trial} and selecting with it"
    script:
        "../scripts/trial.py"


rule evaluate_trials:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=range(config["draws"]),
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        trials=lambda wildcards: of_trials(wildcards.table)(wildcards),
        lib=library("evaluate_trials"),
    output:
        evaluation="<results>/{dataset}/{scene}/{table}.parquet",
    log:
        "<results>/logs/evaluate_trials/{dataset}/{scene}/{table}.log",
    benchmark:
        "<results>/benchmarks/evaluate_trials/{dataset}/{scene}/{table}.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=GPU,
    params:
        names=lambda wildcards: list(cases(wildcards.table)),
        reconstruction=config["reconstruction"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} from the picks of {wildcards.table}"
    script:
        "../scripts/evaluate_trials.py"


rule feature_sweep:
    input:
        evaluations=of_trial_scenes("feature_sweep.parquet", table="feature_sweep"),
        trials=of_trials("feature_sweep"),
        lib=library("feature_sweep"),
    output:
        table=report(
            "<tables>/feature_sweep.tex",
            caption="../report/feature_sweep.rst",
            category="Paper",
            labels={"table": "Tested features", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/feature_sweep.csv",
            caption="../report/feature_sweep.rst",
            category="Paper",
            labels={"table": "Tested features", "form": "numbers"},
        ),
    log:
        "<results>/logs/feature_sweep.log",
    benchmark:
        "<results>/benchmarks/feature_sweep.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        cases=feature_cases(),
        scenes=lambda wildcards: trial_scenes("feature_sweep"),
        facts=lambda wildcards: trial_facts("feature_sweep"),
    message:
        "Writing what other features are worth"
    script:
        "../scripts/feature_sweep.py"


rule scorer_arch:
    input:
        evaluations=of_trial_scenes("scorer_arch.parquet", table="scorer_arch"),
        trials=of_trials("scorer_arch"),
        lib=library("scorer_arch"),
    output:
        table=report(
            "<tables>/scorer_arch.tex",
            caption="../report/scorer_arch.rst",
            category="Paper",
            labels={"table": "Scorer architectures", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/scorer_arch.csv",
            caption="../report/scorer_arch.rst",
            category="Paper",
            labels={"table": "Scorer architectures", "form": "numbers"},
        ),
    log:
        "<results>/logs/scorer_arch.log",
    benchmark:
        "<results>/benchmarks/scorer_arch.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        labels={name: scorer["label"] for name, scorer in scorers().items()},
        scenes=lambda wildcards: trial_scenes("scorer_arch"),
        facts=lambda wildcards: trial_facts("scorer_arch"),
    message:
        "Writing what other scorers are worth"
    script:
        "../scripts/scorer_arch.py"
