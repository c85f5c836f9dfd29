"""How many frames the captures have."""


rule counts:
    input:
        frames=[f"<results>/{d}/{s}/frames.parquet" for d, s in evaluation_scenes()],
        lib=library("counts"),
    output:
        table="<tables>/counts.tex",
        numbers="<tables>/counts.csv",
    log:
        "<results>/logs/counts.log",
    benchmark:
        "<results>/benchmarks/counts.jsonl"
    conda:
        "../envs/fsel.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scenes=evaluation_scenes(),
        datasets=labels(),
    message:
        "Counting frames"
    script:
        "../scripts/counts.py"
