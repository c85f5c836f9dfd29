"""What rules share: each says `use rule stage as ... with`, or `table`, its files."""


rule stage:
    log:
        "<results>/logs/stage.log",
    conda:
        "../envs/fsel.yaml"
    resources:
        **experiment.resources(),
    script:
        "../scripts/run.py"


use rule stage as table with:
    message:
        "Making {output[0]}"


# a table as a browser shows it
use rule stage as table_page with:
    input:
        table="<tables>/{name}.tex",
    output:
        page=report(
            "<tables>/{name}.html",
            category="Tables to read",
            labels={"table": "{name}"},
        ),
    log:
        "<results>/logs/table_page/{name}.log",
    wildcard_constraints:
        name=".+",
    params:
        lib=experiment.library("table_page"),
    message:
        "Making {output.page}"


# every method's picks for the trials of an experiment, see `fsel.experiments.scheme`
use rule stage as select_trials with:
    resources:
        **experiment.resources(4000, 60, "capture"),
    message:
        "Selecting on {wildcards.dataset}/{wildcards.scene}, {rule}"


# what those picks are worth
use rule stage as evaluate_trials with:
    resources:
        **experiment.resources(4000, 60, "reconstruction", experiment.reconstruction_of),
    params:
        reconstruction=experiment.reconstruction_of,
        metrics=experiment.metrics,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene}, {rule}"
