PYTHON ?= python3
CORES ?= 2

.PHONY: ksweep test

# the whole experiment: results/tables/ksweep.tex and results/figures/heatmap.pdf
ksweep: .venv/installed
	.venv/bin/snakemake --cores $(CORES)

test: .venv/installed
	.venv/bin/python -m pytest

.venv/installed: pyproject.toml
	$(PYTHON) -m venv .venv
	.venv/bin/python -m pip install --quiet --editable '.[workflow,dev]'
	touch $@
