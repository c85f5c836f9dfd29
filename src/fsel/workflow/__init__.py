"""What of Snakemake there is: jobs, sources that a rule depends on, and the cluster."""
