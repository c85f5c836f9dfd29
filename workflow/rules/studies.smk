"""Tables beside the paper's: speed. None is part of `rule all`.

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


use rule table as speed_error with:
    input:
        times="<tables>/selection_time.csv",
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
        facts=experiment.facts([experiment.trained]),
