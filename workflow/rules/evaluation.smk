"""Every method on every evaluation problem, and what came of it.

Inputs: problems and trained selectors.
Outputs: <results>/{dataset}/{scene}/draw{draw}/selections.parquet and, of every reconstructor,
evaluation.parquet; the searches' {subsets,oracle}.parquet; <tables>/ksweep.{tex,csv},
<tables>/ksweep_differences.csv, <tables>/heatmap.csv, <figures>/heatmap.{pdf,png}.
"""


# scorers that are shipped or configured, among the results: jobs elsewhere find them there
rule given_scorer:
    input:
        given=kept_here(lambda wildcards: experiment.given_scorers[wildcards.file]),
    output:
        scorer="<results>/selector/given/{file}",
    log:
        "<results>/logs/given_scorer/{file}.log",
    wildcard_constraints:
        file="[^/]+",
    localrule: True
    conda:
        "../envs/fsel.yaml"
    message:
        "Copying {input.given}"
    shell:
        "cp {input.given:q} {output.scorer:q} 2> {log:q}"


use rule stage as select with:
    input:
        **inputs.capture(inputs.DESCRIBED),
        splits=inputs.of_draws(experiment, "split.parquet"),
        features=inputs.of_draws(experiment, "features.parquet"),
        weights=experiment.scorers,
    output:
        selections=inputs.of_draws(experiment, "selections.parquet"),
    log:
        "<results>/logs/select/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/select/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(2000, 30, "capture"),
    params:
        lib=experiment.library("select"),
        practice=experiment.config["practice"],
        hold_out=experiment.config["hold_out"],
        budgets=experiment.config["budgets"],
        seeds=experiment.draw_seeds,
    message:
        "Selecting frames of {wildcards.dataset}/{wildcards.scene}"


use rule stage as evaluate with:
    input:
        **inputs.capture(),
        splits=inputs.of_draws(experiment, "split.parquet"),
        selections=inputs.of_draws(experiment, "selections.parquet"),
    output:
        evaluations=inputs.of_draws(experiment, "{reconstructor}evaluation.parquet"),
    log:
        "<results>/logs/{reconstructor}evaluate/{dataset}/{scene}.log",
    benchmark:
        "<results>/benchmarks/{reconstructor}evaluate/{dataset}/{scene}.jsonl"
    resources:
        **experiment.resources(
            4000, 180, "reconstruction", experiment.reconstruction_of
        ),
    params:
        lib=experiment.library("evaluate", experiment.reconstruction_of),
        reconstruction=experiment.reconstruction_of,
        metrics=experiment.metrics,
    message:
        "Reconstructing {wildcards.dataset}/{wildcards.scene} from every selection"


use rule stage as search_oracle with:
    input:
        **inputs.capture(inputs.DESCRIBED),
        split="<results>/{dataset}/{scene}/draw{draw}/split.parquet",
    output:
        subsets="<results>/{dataset}/{scene}/draw{draw}/subsets.parquet",
        oracle="<results>/{dataset}/{scene}/draw{draw}/oracle.parquet",
    log:
        "<results>/logs/search_oracle/{dataset}/{scene}/draw{draw}.log",
    benchmark:
        "<results>/benchmarks/search_oracle/{dataset}/{scene}/draw{draw}.jsonl"
    resources:
        **experiment.resources(4000, 120, "reconstruction", experiment.reconstruction),
    params:
        lib=experiment.library("search_oracle", experiment.reconstruction),
        search=experiment.config["search"],
        reconstruction=experiment.reconstruction,
        fitness=experiment.fitness,
        metrics=experiment.metrics,
        seed=lambda wildcards: experiment.scene_seed(
            wildcards, "oracle", wildcards.draw
        ),
    message:
        "Searching {wildcards.dataset}/{wildcards.scene}, draw {wildcards.draw}, to compare with"


use rule table as ksweep with:
    input:
        evaluations=inputs.of_problems(
            experiment.problems(), "{reconstructor}evaluation.parquet"
        ),
        oracles=lambda wildcards: inputs.of_problems(
            experiment.searched_by(wildcards), "oracle.parquet"
        ),
    output:
        **shown(
            "ksweep",
            "Input budget sweep",
            "Tables",
            differences="<tables>/{reconstructor}ksweep_differences.csv",
        ),
    log:
        "<results>/logs/{reconstructor}ksweep.log",
    params:
        lib=experiment.library("ksweep"),
        problems=experiment.problems(),
        searched=experiment.searched_by,
        datasets=experiment.labels(),
        budgets=experiment.config["budgets"],
        metrics=experiment.metrics,
        facts=experiment.facts_of,


use rule table as heatmap with:
    input:
        numbers="<tables>/{reconstructor}ksweep.csv",
        differences="<tables>/{reconstructor}ksweep_differences.csv",
    output:
        **shown(
            "heatmap",
            "Gain over the strongest baseline",
            "Heatmaps",
            figures=inputs.figure_files("{reconstructor}heatmap"),
            cells="<tables>/{reconstructor}heatmap.csv",
        ),
    log:
        "<results>/logs/{reconstructor}heatmap.log",
    params:
        lib=experiment.library("heatmap"),
        datasets=experiment.labels(),
        budgets=experiment.config["budgets"],
        facts=experiment.facts_of,
