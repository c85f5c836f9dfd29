"""Labels of the same problems by several reconstructors, and what they change for `ours`.

Inputs: canonical captures of the training dataset's first train scenes; evaluation problems of the
first scenes of every dataset.
Outputs: <results>/label_judge/{labeller}/labels/{scene}/p{coverage}.parquet and splits.parquet,
<results>/label_judge/{labeller}/{trajectories.parquet,seed{seed}.safetensors},
<results>/{dataset}/{scene}/draw{draw}/label_judge/{labeller}/{picks,by_{judge}}.parquet,
<tables>/label_judge.{tex,csv}.
"""

AGAIN = config["label_judge"]
RELABELLED = dict.fromkeys(scenes(TRAINED, "train")[: AGAIN["scenes"]], "train")
AGAIN_DRAWS = range(min(config["draws"], AGAIN["draws"]))


wildcard_constraints:
    labeller=r"[A-Za-z0-9][A-Za-z0-9_.-]*",


use rule label as label_again with:
    input:
        frames=f"<results>/{TRAINED}/{{scene}}/frames.parquet",
        points=f"<results>/{TRAINED}/{{scene}}/points.parquet",
        images=f"<results>/{TRAINED}/{{scene}}/images.npy",
        descriptors=f"<results>/{TRAINED}/{{scene}}/descriptors.parquet",
        lib=lambda wildcards: library("label", again_by(wildcards.labeller)["name"]),
    output:
        labels=expand(
            "<results>/label_judge/{{labeller}}/labels/{{scene}}/p{coverage}.parquet",
            coverage=AGAIN["coverages"],
        ),
        splits="<results>/label_judge/{labeller}/labels/{scene}/splits.parquet",
    log:
        "<results>/logs/label_judge/{labeller}/label/{scene}.log",
    benchmark:
        "<results>/benchmarks/label_judge/{labeller}/label/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(120),
        gpu=lambda wildcards: int(needs_gpu(again_by(wildcards.labeller))),
    params:
        coverages=AGAIN["coverages"],
        search=search_again(),
        reconstruction=lambda wildcards: again_by(wildcards.labeller),
        fitness=FITNESS,
        seed=lambda wildcards: training_seed(wildcards),
    message:
        "Searching for good subsets of {wildcards.scene} by {wildcards.labeller}"


use rule order as order_again with:
    input:
        frames=collect(
            f"<results>/{TRAINED}/{{scene}}/frames.parquet", scene=RELABELLED
        ),
        images=collect(f"<results>/{TRAINED}/{{scene}}/images.npy", scene=RELABELLED),
        splits=collect(
            "<results>/label_judge/{{labeller}}/labels/{scene}/splits.parquet",
            scene=RELABELLED,
        ),
        labels=collect(
            "<results>/label_judge/{{labeller}}/labels/{scene}/p{coverage}.parquet",
            scene=RELABELLED,
            coverage=AGAIN["coverages"],
        ),
        lib=library("order"),
    output:
        trajectories="<results>/label_judge/{labeller}/trajectories.parquet",
    log:
        "<results>/logs/label_judge/{labeller}/order.log",
    benchmark:
        "<results>/benchmarks/label_judge/{labeller}/order.jsonl"
    params:
        scenes=RELABELLED,
        coverages=AGAIN["coverages"],
        kept=search_again()["kept"],
    message:
        "Ordering the subsets searched by {wildcards.labeller}"


use rule train as train_again with:
    input:
        trajectories="<results>/label_judge/{labeller}/trajectories.parquet",
        frames=collect(
            f"<results>/{TRAINED}/{{scene}}/frames.parquet", scene=RELABELLED
        ),
        descriptors=collect(
            f"<results>/{TRAINED}/{{scene}}/descriptors.parquet", scene=RELABELLED
        ),
        splits=collect(
            "<results>/label_judge/{{labeller}}/labels/{scene}/splits.parquet",
            scene=RELABELLED,
        ),
        lib=library("train"),
    output:
        weights=collect(
            "<results>/label_judge/{{labeller}}/seed{seed}.safetensors", seed=SEEDS
        ),
        logs=collect(
            "<results>/label_judge/{{labeller}}/seed{seed}.parquet", seed=SEEDS
        ),
    log:
        "<results>/logs/label_judge/{labeller}/train.log",
    benchmark:
        "<results>/benchmarks/label_judge/{labeller}/train.jsonl"
    params:
        policy="ours",
        scenes=list(RELABELLED),
        epochs=AGAIN["epochs"],
        learning_rate=config["training"]["learning_rate"],
    message:
        "Training {params.policy} on labels by {wildcards.labeller}"


use rule select as select_again with:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=AGAIN_DRAWS,
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        descriptors="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=collect(
            "<results>/label_judge/{{labeller}}/seed{seed}.safetensors", seed=SEEDS
        ),
        lib=library("select"),
    output:
        selections=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/label_judge/{{labeller}}/picks.parquet",
            draw=AGAIN_DRAWS,
        ),
    log:
        "<results>/logs/label_judge/{labeller}/select/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/label_judge/{labeller}/select/{dataset}/{scene}.jsonl"
    params:
        methods=[],
        budgets=AGAIN["budgets"],
        seeds=lambda wildcards: [
            scene_seed(wildcards, "select", draw) for draw in AGAIN_DRAWS
        ],
    message:
        "Selecting frames of {wildcards.dataset}/{wildcards.scene} by labels of {wildcards.labeller}"


use rule evaluate as evaluate_again with:
    input:
        splits=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/split.parquet",
            draw=AGAIN_DRAWS,
        ),
        selections=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/label_judge/{{labeller}}/picks.parquet",
            draw=AGAIN_DRAWS,
        ),
        frames="<results>/{dataset}/{scene}/frames.parquet",
        points="<results>/{dataset}/{scene}/points.parquet",
        images="<results>/{dataset}/{scene}/images.npy",
        lib=lambda wildcards: library("evaluate", judging_again(wildcards)["name"]),
    output:
        evaluations=expand(
            "<results>/{{dataset}}/{{scene}}/draw{draw}/label_judge/{{labeller}}/by_{{judge}}.parquet",
            draw=AGAIN_DRAWS,
        ),
    log:
        "<results>/logs/label_judge/{labeller}/evaluate/{judge}/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/label_judge/{labeller}/evaluate/{judge}/{dataset}/{scene}.jsonl"
    resources:
        mem_mb=per_reconstruction(4000),
        runtime=per_reconstruction(60),
        gpu=lambda wildcards: int(needs_gpu(judging_again(wildcards))),
    params:
        reconstruction=judging_again,
        metrics=["psnr"],
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} by {wildcards.judge}, labels of {wildcards.labeller}"


rule label_judge:
    input:
        evaluations=lambda wildcards: [
            f"<results>/{problem}/label_judge/{labeller}/by_{judge}.parquet"
            for judge in again_judges()
            for labeller in again_labellers()
            for problem in problems_again()
        ],
        labels=lambda wildcards: [
            f"<results>/label_judge/{labeller}/labels/{scene}/p{coverage}.parquet"
            for labeller in again_labellers()
            for scene in RELABELLED
            for coverage in AGAIN["coverages"]
        ],
        lib=library("label_judge"),
    output:
        table=report(
            "<tables>/label_judge.tex",
            caption="../report/label_judge.rst",
            category="Paper",
            labels={"table": "Labels by another reconstructor", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/label_judge.csv",
            caption="../report/label_judge.rst",
            category="Paper",
            labels={"table": "Labels by another reconstructor", "form": "numbers"},
        ),
    log:
        "<results>/logs/label_judge.log",
    benchmark:
        "<results>/benchmarks/label_judge.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(10),
    params:
        problems=lambda wildcards: problems_again(),
        labellers=lambda wildcards: {
            name: judged_by(name, section)
            for name, section in again_labellers().items()
        },
        judges=lambda wildcards: {
            name: judged_by(name, section) for name, section in again_judges().items()
        },
        labelled=len(RELABELLED) * len(AGAIN["coverages"]),
        budgets=AGAIN["budgets"],
        facts=facts(),
    message:
        "Writing what labels by another reconstructor change"
    script:
        "../scripts/label_judge.py"
