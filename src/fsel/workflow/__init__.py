"""Parts that deal with Snakemake: jobs, sources that a rule depends on, and the cluster."""
