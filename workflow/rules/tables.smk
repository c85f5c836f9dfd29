"""The other tables and figures: one file of `fsel.experiments` each, and a line of its registry.

None is part of `rule all`: they are made when asked for by name, or by `paper` all of the paper's
that can be made here.
"""

for declared in tables.rules():

    rule:
        name:
            declared.name
        input:
            **declared.inputs,
        output:
            **{
                name: (
                    report(path, caption="../report/table.rst", **declared.shown[name])
                    if name in declared.shown
                    else directory(path) if name == "folder" else path
                )
                for name, path in declared.outputs.items()
            },
        log:
            declared.log,
        benchmark:
            declared.benchmark
        wildcard_constraints:
            **declared.constraints,
        conda:
            "../envs/fsel.yaml"
        resources:
            **declared.resources,
        params:
            **declared.params,
        message:
            declared.message
        script:
            "../scripts/run.py"


rule paper:
    input:
        lambda wildcards: tables.of_the_paper(),
    localrule: True
