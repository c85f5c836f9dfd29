"""Tables beside the paper's: speed and hard cases. None is part of `rule all`.

Inputs: problems, evaluations, searches and labels of the sweep.
Outputs: <tables>/{table}.{tex,csv}.
"""


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
