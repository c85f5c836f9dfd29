# The entry for `snakemake` in a clone; other workflows import the file that it includes.
include: "workflow/Snakefile"


# of an included file, Snakemake takes no default target
workflow.default_target = "all"
