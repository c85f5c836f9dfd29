"""Tables beside the paper's: speed. None is part of `rule all`.

Inputs: problems, evaluations, searches and labels of the sweep.
Outputs: <tables>/{table}.{tex,csv}.
"""


use rule table as speed_error with:
    input:
        **inputs.capture(
            inputs.DESCRIBED,
            folder=f"<results>/{inputs.joined(experiment.evaluation_scenes)[0]}",
        ),
        split=inputs.of_problems(experiment.problems(), "split.parquet")[0],
        weights=experiment.scorers,
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
    benchmark:
        "<results>/benchmarks/speed_error.jsonl"
    resources:
        **experiment.resources(4000, 60, "capture"),
    params:
        lib=experiment.library("speed_error"),
        problems=lambda wildcards: scenes.held_out_problems(experiment),
        k=experiment.config["search"]["k"],
        appearance=experiment.config["appearance"],
        facts=experiment.facts([experiment.trained]),
