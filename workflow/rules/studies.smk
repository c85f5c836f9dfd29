"""Tables beside the paper's: equal candidate pools, speed, hard cases. None is part of `rule all`.

Inputs: problems, evaluations, searches and labels of the sweep.
Outputs: <tables>/{table}.{tex,csv}; those of candidate_pools for every reconstructor.
"""


use rule select_trials as select_candidate_pools with:
    input:
        **inputs.captures([SCENE]),
        described="<results>/{dataset}/{scene}/descriptors.parquet",
        splits=inputs.of_draws(experiment, "split.parquet"),
        weights=[*experiment.weights("less_is_more"), *experiment.fsel],
    output:
        picks="<results>/{dataset}/{scene}/candidate_pools_picks.parquet",
    log:
        "<results>/logs/select_candidate_pools/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select_candidate_pools/{dataset}/{scene}.jsonl"
    params:
        lib=experiment.library("select_candidate_pools"),
        settings=lambda wildcards: {
            "budgets": experiment.config["budgets"],
            "seeds": experiment.draw_seeds(wildcards),
        },


use rule evaluate_trials as evaluate_candidate_pools with:
    input:
        **inputs.captures([SCENE]),
        splits=inputs.of_draws(experiment, "split.parquet"),
        picks=["<results>/{dataset}/{scene}/candidate_pools_picks.parquet"],
    output:
        evaluation="<results>/{dataset}/{scene}/{reconstructor}candidate_pools.parquet",
    log:
        "<results>/logs/{reconstructor}evaluate_candidate_pools/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate_candidate_pools/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(
            4000, 120, "reconstruction", experiment.reconstruction_of
        ),
    params:
        lib=experiment.library("evaluate_candidate_pools", experiment.reconstruction_of),
        metrics=["psnr", "ssim", "gmsd"],
        settings=rules.select_candidate_pools.params.settings,


use rule table as candidate_pools with:
    input:
        evaluations=inputs.of_scenes(
            experiment.evaluation_scenes, "{reconstructor}candidate_pools.parquet"
        ),
    output:
        **shown("candidate_pools", "Equal candidate pools"),
    log:
        "<results>/logs/{reconstructor}candidate_pools.log",
    params:
        **scenes.of_table(experiment, scenes.evaluated),
        lib=experiment.library("candidate_pools"),
        budgets=experiment.config["budgets"],


use rule table as selection_time with:
    input:
        **inputs.capture(
            folder=f"<results>/{inputs.joined(experiment.evaluation_scenes)[0]}"
        ),
        weights=experiment.scorers,
    output:
        **shown("selection_time", "Selection time", "Tables", folder=""),
    log:
        "<results>/logs/selection_time.log",
    benchmark:
        "<results>/benchmarks/selection_time.jsonl"
    resources:
        **experiment.resources(4000, 60, "capture"),
    params:
        lib=experiment.library("selection_time"),
        pools=experiment.config["timing"]["pools"],
        k=experiment.config["timing"]["k"],
        targets=experiment.config["targets"],
        appearance=experiment.config["appearance"],


use rule stage as speed_settings with:
    input:
        **inputs.captures(inputs.joined(experiment.evaluation_scenes), inputs.DESCRIBED),
        splits=inputs.of_problems(experiment.problems(1), "split.parquet"),
    output:
        numbers="<results>/speed_settings.csv",
    log:
        "<results>/logs/speed_settings.log",
    benchmark:
        "<results>/benchmarks/speed_settings.jsonl"
    resources:
        **experiment.resources(4000, 60, "reconstruction", experiment.reconstruction),
    params:
        lib=experiment.library("speed_settings"),
        generated=[
            experiment.generated(*scene) for scene in experiment.evaluation_scenes
        ],
        k=experiment.config["search"]["k"],
        reconstruction=experiment.reconstruction,
    message:
        "Measuring the reconstructor's settings"


use rule table as speed_error with:
    input:
        times="<tables>/selection_time.csv",
        settings="<results>/speed_settings.csv",
        evaluations=lambda wildcards: inputs.of_problems(
            scenes.held_out_problems(experiment), "evaluation.parquet"
        ),
        oracles=inputs.of_problems(experiment.searched_problems(), "oracle.parquet"),
    output:
        **shown(
            "speed_error",
            "Speed against error",
            "Speed",
            **inputs.table_files("speed_error"),
            figures=inputs.figure_files("speed_error"),
        ),
    log:
        "<results>/logs/speed_error.log",
    params:
        lib=experiment.library("speed_error"),
        problems=lambda wildcards: scenes.held_out_problems(experiment),
        k=experiment.config["search"]["k"],


use rule speed_settings as economy with:
    input:
        **inputs.captures(inputs.joined(experiment.evaluation_scenes), inputs.DESCRIBED),
        splits=inputs.of_problems(experiment.problems(1), "split.parquet"),
    output:
        **shown("economy", "Modelling only what a scene needs", "Speed", folder=""),
    log:
        "<results>/logs/economy.log",
    benchmark:
        "<results>/benchmarks/economy.jsonl"
    params:
        lib=experiment.library("economy"),
        appearance=experiment.config["appearance"],
    message:
        "Making {output[0]}"


use rule table as stability with:
    output:
        **shown("stability", "Hard cases", "Numerics", folder=""),
    log:
        "<results>/logs/stability.log",
    benchmark:
        "<results>/benchmarks/stability.jsonl"
    resources:
        **experiment.resources(2000),
    params:
        lib=experiment.library("stability"),
