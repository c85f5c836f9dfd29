"""The paper's other tables and figures; none is part of `rule all`.

They are made when requested by path, as <tables>/handsign.tex, or all by `paper`.
Inputs: problems, selections and evaluations of the sweep, labels, trained selectors.
Outputs: <tables>/{reconstructor}{table}.{tex,csv}, <figures>/{figure}.{pdf,png,csv}; what they are
made of in <results>/{dataset}/{scene} and <results>/trials.
"""

SCENE = "{dataset}/{scene}"


rule paper:
    input:
        lambda wildcards: paper.targets(),
    localrule: True


use rule table as handsign with:
    input:
        evaluations=inputs.of_problems(
            experiment.problems(), "{reconstructor}evaluation.parquet"
        ),
    output:
        **shown("handsign", "Learned versus untrained"),
    log:
        "<results>/logs/{reconstructor}handsign.log",
    params:
        lib=experiment.library("handsign"),
        problems=experiment.problems(),
        datasets=experiment.labels(),
        budgets=experiment.config["budgets"],
        facts=experiment.facts_of,


use rule handsign as seedvar with:
    output:
        **shown("seedvar", "Seed variability"),
    log:
        "<results>/logs/{reconstructor}seedvar.log",


use rule evaluate_trials as evaluate_searched with:
    input:
        **inputs.captures([SCENE]),
        splits=inputs.of_draws(
            experiment, "split.parquet", range(experiment.config["oracle"]["draws"])
        ),
        picks=inputs.of_draws(
            experiment, "subsets.parquet", range(experiment.config["oracle"]["draws"])
        ),
    output:
        evaluation="<results>/{dataset}/{scene}/{reconstructor}searched.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_searched/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_searched/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("evaluate_searched", experiment.reconstruction_of),
        metrics=["psnr"],
        settings={},


use rule table as ga_vs_learned with:
    input:
        evaluations=lambda wildcards: inputs.of_problems(
            scenes.held_out_problems(experiment, scenes.searched),
            "{reconstructor}evaluation.parquet",
        ),
        searched=scenes.files(
            experiment, scenes.searched, "{reconstructor}searched.parquet"
        ),
    output:
        **shown("ga_vs_learned", "Comparison with the search"),
    log:
        "<results>/logs/{reconstructor}ga_vs_learned.log",
    params:
        **scenes.of_table(experiment, scenes.searched),
        lib=experiment.library("ga_vs_learned"),
        problems=lambda wildcards: scenes.held_out_problems(experiment, scenes.searched),
        k=experiment.config["search"]["k"],


use rule select_trials as select_geometry with:
    input:
        **inputs.captures([SCENE]),
        described="<results>/{dataset}/{scene}/descriptors.parquet",
        splits=inputs.of_draws(experiment, "split.parquet"),
        weights=lambda wildcards: scenes.from_labels(
            experiment,
            inputs.scorer_files(experiment, "less_is_more_geometry")["weights"],
        ),
    output:
        picks="<results>/{dataset}/{scene}/geometry_picks.parquet",
    log:
        "<results>/logs/select_geometry/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_geometry/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("select_geometry"),
        settings={"budgets": experiment.config["budgets"]},


use rule evaluate_trials as evaluate_geometry with:
    input:
        **inputs.captures([SCENE]),
        splits=inputs.of_draws(experiment, "split.parquet"),
        picks=["<results>/{dataset}/{scene}/geometry_picks.parquet"],
    output:
        evaluation="<results>/{dataset}/{scene}/{reconstructor}geometry.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_geometry/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_geometry/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(
            4000, 180, "reconstruction", experiment.reconstruction_of
        ),
    params:
        lib=experiment.library("evaluate_geometry", experiment.reconstruction_of),
        metrics=["psnr"],
        settings={"budgets": experiment.config["budgets"]},


use rule stage as measure_costs with:
    input:
        **inputs.capture(inputs.DESCRIBED),
        split="<results>/{dataset}/{scene}/draw0/split.parquet",
        weights=lambda wildcards: scenes.from_labels(
            experiment,
            [
                inputs.scorer_files(experiment, policy)["weights"][0]
                for policy in inputs.COSTED
            ],
        ),
    output:
        costs="<results>/{dataset}/{scene}/{reconstructor}costs.parquet",
        times="<results>/{dataset}/{scene}/{reconstructor}times.parquet",
    log:
        "<results>/logs/{reconstructor}measure_costs/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}measure_costs/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(4000, 30, "reconstruction", experiment.reconstruction_of),
    params:
        lib=experiment.library("measure_costs", experiment.reconstruction_of),
        budgets=experiment.config["budgets"],
        appearance=experiment.config["appearance"],
        reconstruction=experiment.reconstruction_of,
    message:
        "Measuring time and memory on {wildcards.dataset}/{wildcards.scene}"


use rule table as time_quality with:
    input:
        evaluations=lambda wildcards: inputs.of_scenes(
            scenes.held_out(experiment),
            "{reconstructor}evaluation.parquet",
            range(experiment.config["draws"]),
        ),
        variant=scenes.files(
            experiment, scenes.held_out, "{reconstructor}geometry.parquet"
        ),
        costs=scenes.files(experiment, scenes.held_out, "{reconstructor}costs.parquet"),
        times=scenes.files(experiment, scenes.held_out, "{reconstructor}times.parquet"),
    output:
        **shown("time_quality", "Quality, runtime and memory"),
    log:
        "<results>/logs/{reconstructor}time_quality.log",
    params:
        **scenes.of_table(experiment, scenes.held_out),
        lib=experiment.library("time_quality"),
        problems=lambda wildcards: scenes.problems(
            scenes.held_out(experiment), range(experiment.config["draws"])
        ),
        budgets=experiment.config["budgets"],


use rule select_trials as select_crosscapture with:
    input:
        **inputs.captures([SCENE]),
        described="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=experiment.scorers,
    output:
        picks="<results>/{dataset}/{scene}/crosscapture_picks.parquet",
    log:
        "<results>/logs/select_crosscapture/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_crosscapture/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("select_crosscapture"),
        settings=lambda wildcards: {
            "held_out": scenes.passes(experiment, wildcards),
            "every": experiment.config["crosscapture"]["every"],
            "targets": experiment.config["crosscapture"]["targets"],
            "draws": experiment.config["draws"],
            "budgets": paper.pass_budgets,
            "seed": experiment.scene_seed(wildcards, "crosscapture"),
        },


use rule evaluate_trials as evaluate_crosscapture with:
    input:
        **inputs.captures([SCENE]),
        picks=["<results>/{dataset}/{scene}/crosscapture_picks.parquet"],
    output:
        evaluation="<results>/{dataset}/{scene}/{reconstructor}crosscapture.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_crosscapture/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_crosscapture/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("evaluate_crosscapture", experiment.reconstruction_of),
        settings=rules.select_crosscapture.params.settings,


use rule table as crosscapture with:
    input:
        evaluations=scenes.files(
            experiment, scenes.rooms, "{reconstructor}crosscapture.parquet"
        ),
    output:
        **shown("crosscapture", "Cross-capture"),
    log:
        "<results>/logs/{reconstructor}crosscapture.log",
    params:
        **scenes.of_table(experiment, scenes.rooms),
        lib=experiment.library("crosscapture"),
        budgets=paper.pass_budgets,
        metrics=experiment.metrics,


use rule select_trials as select_objects with:
    input:
        **inputs.captures([SCENE]),
        described="<results>/{dataset}/{scene}/descriptors.parquet",
        weights=[*experiment.weights("less_is_more"), *experiment.fsel],
    output:
        picks="<results>/{dataset}/{scene}/objects_picks.parquet",
    log:
        "<results>/logs/select_objects/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_objects/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("select_objects"),
        settings=lambda wildcards: {
            "draws": experiment.config["draws"],
            "targets": experiment.config["targets"],
            "k": experiment.budget_near(30),
            "long_side": experiment.reconstruction["long_side"],
            "seed": experiment.scene_seed(wildcards, "objects"),
        },


use rule evaluate_trials as evaluate_objects with:
    input:
        **inputs.captures([SCENE]),
        picks=["<results>/{dataset}/{scene}/objects_picks.parquet"],
    output:
        evaluation="<results>/{dataset}/{scene}/{reconstructor}objects.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_objects/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_objects/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("evaluate_objects", experiment.reconstruction_of),
        settings=rules.select_objects.params.settings,


use rule table as objectcentric with:
    input:
        evaluations=scenes.files(
            experiment, scenes.of_objects, "{reconstructor}objects.parquet"
        ),
    output:
        **shown("objectcentric", "Object-centric"),
    log:
        "<results>/logs/{reconstructor}objectcentric.log",
    params:
        **scenes.of_table(experiment, scenes.of_objects),
        lib=experiment.library("objectcentric"),
        datasets=lambda wildcards: experiment.labels(
            scenes.datasets_of(scenes.of_objects(experiment))
        ),
        metrics=experiment.metrics,


use rule stage as trial_feature_sweep with:
    input:
        **cases.files(experiment, "feature_sweep"),
    output:
        picks="<results>/trials/feature_sweep/{trial}.parquet",
    log:
        "<results>/logs/trial_feature_sweep/{trial}.log",
    benchmark:
        "<results>/benchmarks/trial_feature_sweep/{trial}.jsonl"
    resources:
        **experiment.resources(4000, 120),
    params:
        **cases.training(experiment, "feature_sweep"),
        lib=experiment.library("trial_feature_sweep"),
        case=lambda wildcards: cases.feature_cases(experiment)[wildcards.trial],
        k=experiment.budget_near(30),
    message:
        "Training {wildcards.trial} and selecting with it, {rule}"


use rule evaluate_trials as evaluate_feature_sweep with:
    input:
        **inputs.captures([SCENE]),
        splits=inputs.of_draws(experiment, "split.parquet"),
        picks=expand(
            "<results>/trials/feature_sweep/{trial}.parquet",
            trial=cases.feature_cases(experiment),
        ),
    output:
        evaluation="<results>/{dataset}/{scene}/{reconstructor}feature_sweep.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_feature_sweep/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_feature_sweep/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("evaluate_feature_sweep", experiment.reconstruction_of),
        metrics=["psnr"],
        settings=lambda wildcards: {
            "dataset": wildcards.dataset,
            "scene": wildcards.scene,
        },


use rule table as feature_sweep with:
    input:
        evaluations=lambda wildcards: inputs.of_scenes(
            scenes.tried(experiment, "feature_sweep"),
            "{reconstructor}feature_sweep.parquet",
        ),
        trials=rules.evaluate_feature_sweep.input.picks,
    output:
        **shown("feature_sweep", "Tested features"),
    log:
        "<results>/logs/{reconstructor}feature_sweep.log",
    params:
        **cases.of_table(experiment, "feature_sweep"),
        lib=experiment.library("feature_sweep"),
        cases=cases.feature_cases(experiment),


use rule trial_feature_sweep as trial_scorer_arch with:
    input:
        **cases.files(experiment, "scorer_arch"),
    output:
        picks="<results>/trials/scorer_arch/{trial}.parquet",
    log:
        "<results>/logs/trial_scorer_arch/{trial}.log",
    benchmark:
        "<results>/benchmarks/trial_scorer_arch/{trial}.jsonl"
    params:
        **cases.training(experiment, "scorer_arch"),
        lib=experiment.library("trial_scorer_arch"),
        case=lambda wildcards: cases.scorer_cases(experiment)[wildcards.trial],
        k=experiment.budget_near(20),


use rule evaluate_feature_sweep as evaluate_scorer_arch with:
    input:
        **inputs.captures([SCENE]),
        splits=inputs.of_draws(experiment, "split.parquet"),
        picks=expand(
            "<results>/trials/scorer_arch/{trial}.parquet",
            trial=cases.scorer_cases(experiment),
        ),
    output:
        evaluation="<results>/{dataset}/{scene}/{reconstructor}scorer_arch.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_scorer_arch/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_scorer_arch/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("evaluate_scorer_arch", experiment.reconstruction_of),


use rule table as scorer_arch with:
    input:
        evaluations=lambda wildcards: inputs.of_scenes(
            scenes.tried(experiment, "scorer_arch"),
            "{reconstructor}scorer_arch.parquet",
        ),
        trials=rules.evaluate_scorer_arch.input.picks,
    output:
        **shown("scorer_arch", "Scorer architectures"),
    log:
        "<results>/logs/{reconstructor}scorer_arch.log",
    params:
        **cases.of_table(experiment, "scorer_arch"),
        lib=experiment.library("scorer_arch"),
        labels=cases.scorer_labels(experiment),


use rule stage as pair_poses with:
    input:
        source=kept_here(experiment.datasets.raw_capture),
    output:
        **inputs.capture(folder=f"{inputs.SCENE}/sources/given", prefix="given_"),
        **inputs.capture(
            folder=f"{inputs.SCENE}/sources/estimated", prefix="estimated_"
        ),
    log:
        "<results>/logs/pair_poses/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/pair_poses/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(4000, 240)
        | {"gpu": gpus_of(experiment.config["pose_sources"]["poses"])},
    params:
        **inputs.ingested(experiment, experiment.config["long_side"]),
        lib=experiment.library("pair_poses"),
        poses=experiment.config["pose_sources"]["poses"],
        model=experiment.config["pose_sources"]["model"],
    message:
        "Reading two sources of poses of {wildcards.dataset}/{wildcards.scene}"


use rule describe as describe_paired with:
    input:
        **inputs.capture(folder=f"{inputs.SCENE}/sources/given"),
    output:
        descriptors=f"{inputs.SCENE}/sources/given/descriptors.parquet",
    log:
        "<results>/logs/describe_paired/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/describe_paired/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("describe"),


use rule select_trials as select_paired with:
    input:
        **inputs.captures([f"{SCENE}/sources/given", f"{SCENE}/sources/estimated"]),
        described=f"{inputs.SCENE}/sources/given/descriptors.parquet",
        weights=experiment.scorers,
    output:
        picks=f"{inputs.SCENE}/sources/paired_picks.parquet",
    log:
        "<results>/logs/select_paired/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_paired/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("select_paired"),
        settings=lambda wildcards: {
            "draws": experiment.config["draws"],
            "budgets": experiment.config["budgets"],
            "targets": experiment.config["targets"],
            "seed": experiment.scene_seed(wildcards, "sources"),
            "split_seed": experiment.scene_seed(wildcards, "split"),
        },


use rule evaluate_trials as evaluate_paired with:
    input:
        **inputs.captures([f"{SCENE}/sources/given", f"{SCENE}/sources/estimated"]),
        picks=[f"{inputs.SCENE}/sources/paired_picks.parquet"],
    output:
        evaluation=f"{inputs.SCENE}/sources/{{reconstructor}}paired.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_paired/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_paired/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("evaluate_paired", experiment.reconstruction_of),
        settings=rules.select_paired.params.settings,


use rule table as pose_sources with:
    input:
        evaluations=scenes.files(
            experiment, scenes.posed_twice, "sources/{reconstructor}paired.parquet"
        ),
    output:
        **shown("pose_sources", "Two sources of poses"),
    log:
        "<results>/logs/{reconstructor}pose_sources.log",
    params:
        **scenes.of_table(experiment, scenes.posed_twice),
        lib=experiment.library("pose_sources"),
        names=lambda wildcards: paper.pose_labels(),
        budgets=experiment.config["budgets"],
        metrics=experiment.metrics,


use rule stage as evaluate_transfer with:
    input:
        **inputs.capture(),
        splits=inputs.of_draws(experiment, "split.parquet", paper.draws),
        selections=inputs.of_draws(experiment, "selections.parquet", paper.draws),
    output:
        evaluations=inputs.of_draws(
            experiment, "{compared}/transfer.parquet", paper.draws
        ),
    log:
        "<results>/logs/evaluate_transfer/{dataset}/{scene}/{compared}.log",
    benchmark:
        "<results>/benchmarks/evaluate_transfer/{dataset}/{scene}/{compared}.jsonl"
    resources:
        **experiment.resources(
            4000, 120, "reconstruction", paper.reconstruction("transfer")
        ),
    params:
        lib=experiment.library("evaluate_transfer", paper.reconstruction("transfer")),
        reconstruction=paper.reconstruction("transfer"),
        metrics=experiment.metrics,
        budgets=lambda wildcards: paper.budgets("budgets"),
        seeds=list(range(experiment.config["transfer"]["seeds"])),
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} by {wildcards.compared}"


use rule table as transfer with:
    input:
        evaluations=lambda wildcards: paper.evaluations("transfer", paper.draws),
        programs=paper.programs("transfer"),
    output:
        **shown(
            "transfer",
            "Other reconstructors",
            folder="",
            differences="<tables>/transfer_differences.csv",
        ),
    log:
        "<results>/logs/transfer.log",
    params:
        lib=paper.library("transfer", "transfer"),
        problems=lambda wildcards: scenes.problems(
            scenes.held_out(experiment), paper.draws
        ),
        reconstructors=lambda wildcards: paper.described("transfer"),
        budgets=lambda wildcards: paper.budgets("budgets"),
        seeds=list(range(experiment.config["transfer"]["seeds"])),
        metrics=experiment.metrics,
        facts=experiment.facts([experiment.trained]),


use rule stage as evaluate_reconchoice with:
    input:
        **inputs.capture(),
        split="<results>/{dataset}/{scene}/draw{draw}/split.parquet",
        selections="<results>/{dataset}/{scene}/draw{draw}/selections.parquet",
    output:
        evaluation="<results>/{dataset}/{scene}/draw{draw}/{compared}/reconchoice.parquet",
    log:
        "<results>/logs/evaluate_reconchoice/{dataset}/{scene}/{draw}/{compared}.log",
    benchmark:
        "<results>/benchmarks/evaluate_reconchoice/{dataset}/{scene}/{draw}/{compared}.jsonl"
    resources:
        **experiment.resources(
            experiment.config["transfer"]["memory"] // 1_000_000,
            60,
            reconstruction=paper.reconstruction("reconchoice"),
        ),
    params:
        lib=experiment.library(
            "evaluate_reconchoice", paper.reconstruction("reconchoice")
        ),
        reconstruction=paper.reconstruction("reconchoice"),
        metrics=experiment.metrics,
        budgets=lambda wildcards: paper.budgets("inputs"),
        seeds=list(range(experiment.config["transfer"]["seeds"])),
        memory=int(experiment.config["transfer"]["memory"]),
    message:
        "Measuring {wildcards.compared} on {wildcards.dataset}/{wildcards.scene}"


use rule table as reconchoice with:
    input:
        evaluations=lambda wildcards: paper.evaluations("reconchoice", paper.draws),
        programs=paper.programs("reconchoice"),
    output:
        **shown("reconchoice", "Reconstructors", folder=""),
    log:
        "<results>/logs/reconchoice.log",
    params:
        lib=paper.library("reconchoice", "reconchoice"),
        problems=lambda wildcards: scenes.problems(
            scenes.held_out(experiment), paper.draws
        ),
        reconstructors=lambda wildcards: paper.described("reconchoice"),
        metrics=experiment.metrics,
        memory=int(experiment.config["transfer"]["memory"]),
        facts=experiment.facts([experiment.trained]),


use rule table as pipeline_figure with:
    input:
        **inputs.chosen(
            paper.searched,
            *inputs.CAPTURE,
            "splits",
            "labels",
            "trajectories",
        ),
    output:
        **shown(
            "pipeline_figure",
            "Search and labels",
            figures=inputs.figure_files("pipeline"),
            numbers="<figures>/pipeline.csv",
        ),
    log:
        "<results>/logs/pipeline_figure.log",
    resources:
        **experiment.resources(grows="capture"),
    params:
        lib=experiment.library("pipeline_figure"),
        scenes=lambda wildcards: paper.searched_scenes(),
        facts=experiment.facts([experiment.trained]),


use rule generate as generate_pictures with:
    output:
        folder=directory("<results>/{dataset}/{scene}/pictures/data"),
    log:
        "<results>/logs/generate_pictures/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/generate_pictures/{dataset}/{scene}.jsonl"
    params:
        **paper.picture_size(),


use rule ingest as ingest_pictures with:
    input:
        source=kept_here(inputs.filmed_anew(experiment, "pictures/data")),
    output:
        **inputs.capture(folder=f"{inputs.SCENE}/pictures"),
    log:
        "<results>/logs/ingest_pictures/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/ingest_pictures/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(2000, 240),
    params:
        lib=experiment.library("ingest"),
        long_side=paper.pictured["long_side"],


use rule table as qualitative with:
    input:
        **inputs.chosen(
            lambda wildcards: paper.pictured_scene(wildcards.dataset),
            *inputs.CAPTURE,
            "split",
            "selections",
            "evaluations",
        ),
        programs=paper.programs("pictures"),
    output:
        **shown(
            "views",
            "Views",
            figures=inputs.figure_files("qualitative_{dataset}"),
            numbers="<figures>/qualitative_{dataset}.csv",
        ),
    log:
        "<results>/logs/qualitative/{dataset}.log",
    benchmark:
        "<results>/benchmarks/qualitative/{dataset}.jsonl"
    resources:
        **experiment.resources(4000, 60, "capture", paper.pictured),
    params:
        lib=paper.library("qualitative", "pictures"),
        views=3,
        k=experiment.budget_near(40),
        reconstruction=paper.pictured,
        facts=lambda wildcards: paper.picture_facts(wildcards.dataset),


use rule qualitative as teaser with:
    input:
        **paper.pictured_scene(experiment.evaluation_scenes[0][0]),
        programs=paper.programs("pictures"),
    output:
        **shown(
            "views",
            "Full sequence, Uniform, ours",
            figures=inputs.figure_files("teaser"),
            numbers="<figures>/teaser.csv",
        ),
    log:
        "<results>/logs/teaser.log",
    benchmark:
        "<results>/benchmarks/teaser.jsonl"
    params:
        lib=paper.library("teaser", "pictures"),
        views=1,
        k=experiment.budget_near(30),
        facts=lambda wildcards: paper.picture_facts(experiment.evaluation_scenes[0][0]),


use rule qualitative as real_world with:
    input:
        **inputs.chosen(
            paper.pictured_room,
            *inputs.CAPTURE,
            "selected_from",
            "picks",
            "evaluation",
        ),
        programs=paper.programs("pictures"),
    output:
        **shown(
            "real_world",
            "One capture from others of the place",
            figures=inputs.figure_files("real_world"),
            numbers="<figures>/real_world.csv",
        ),
    log:
        "<results>/logs/real_world.log",
    benchmark:
        "<results>/benchmarks/real_world.jsonl"
    params:
        lib=paper.library("real_world", "pictures"),
        k=experiment.budget_near(30),
        facts=lambda wildcards: paper.picture_facts(scenes.rooms(experiment)[0][0]),
