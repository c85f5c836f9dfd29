"""The same picks under the further reconstructors of `reconstruction`, when it is a list.

Inputs: problems and picks.
Outputs: <results>/{dataset}/{scene}/draw{draw}/{judge}/evaluation.parquet,
<tables>/{judge}/{ksweep,handsign,seedvar}.{tex,csv}, <tables>/{judge}/ksweep_differences.csv,
<figures>/{judge}/heatmap.{pdf,png}.
"""


wildcard_constraints:
    judge=r"[A-Za-z0-9][A-Za-z0-9_.-]*",


use rule seedvar as seedvar_further with:
    input:
        evaluations=collect(
            "<results>/{problem}/{{judge}}/evaluation.parquet",
            problem=evaluation_problems(config["draws"]),
        ),
        lib=library("seedvar"),
    output:
        table=report(
            "<tables>/{judge}/seedvar.tex",
            caption="../report/seedvar.rst",
            category="Paper",
            labels={"table": "Seed variability, {judge}", "form": "LaTeX"},
        ),
        numbers=report(
            "<tables>/{judge}/seedvar.csv",
            caption="../report/seedvar.rst",
            category="Paper",
            labels={"table": "Seed variability, {judge}", "form": "numbers"},
        ),
    log:
        "<results>/logs/seedvar/{judge}.log",
    benchmark:
        "<results>/benchmarks/seedvar/{judge}.jsonl"
    params:
        **{**WHOLE, "facts": judge_facts},
        problems=evaluation_problems(config["draws"]),
