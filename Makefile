PYTHON ?= python3
CORES ?= 2

.PHONY: ksweep test weights

# the whole experiment: results/tables/ksweep.tex and results/figures/heatmap.pdf
ksweep: .venv/installed
	.venv/bin/snakemake --cores $(CORES)

test: .venv/installed
	.venv/bin/python -m pytest

# the scorer inside the package and what `-k auto` predicts by, made anew: src/fsel/selector/weights
WEIGHTS = results/selector/fsel/seed0.json results/selector/budget.json
weights: .venv/installed
	.venv/bin/snakemake --cores $(CORES) $(WEIGHTS)
	.venv/bin/python -m fsel.stages.ship $(WEIGHTS)

.venv/installed: pyproject.toml
	$(PYTHON) -m venv .venv
	.venv/bin/python -m pip install --quiet --editable '.[workflow,dev]'
	touch $@
