"""What every rule of a stage has: each says `use rule stage as ... with` its files."""


rule stage:
    log:
        "<results>/logs/stage.log",
    conda:
        "../envs/fsel.yaml"
    resources:
        **experiment.resources(Size()),
    script:
        "../scripts/run.py"
