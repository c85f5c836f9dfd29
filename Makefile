PYTHON ?= python3
CORES ?= 2
# images of containers often set it: every process would compile pandas anew, a second each
unexport PYTHONDONTWRITEBYTECODE

.PHONY: ksweep check test how_many labels docs rulegraph

# the whole experiment: results/tables/ksweep.tex and results/figures/heatmap.pdf
ksweep: .venv/installed
	.venv/bin/snakemake --cores $(CORES)

# compare that run's tables with those of docs/results, to the byte: docs/numerics.md
check: .venv/installed
	.venv/bin/python tools/check_reference.py

test: .venv/dev
	.venv/bin/python -m pytest --numprocesses $(CORES) --dist worksteal

# what fewer frames lose on real captures, four hours of one core: `-k auto` and docs/results/how_many.md
how_many: .venv/installed
	OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 .venv/bin/python tools/how_many.py results/how_many/rows.jsonl
	.venv/bin/python tools/result_pages.py

# make the paper's selector again, in the package, from labels with the paper's numbers
LABELS = results/labels/selector
OURS = $(LABELS)/seed0.safetensors $(LABELS)/no_appearance/seed0.safetensors
labels: .venv/installed
	.venv/bin/snakemake --cores $(CORES) $(OURS) --configfile config/labels.yaml
	.venv/bin/python tools/ship_weights.py $(OURS)

# the table of real captures that README.md leads with, three hours: docs/results/captures_unknown.md
.PHONY: captures
CAPTURES = OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 .venv/bin/python benchmarks/captures
ROWS = results/captures_unknown.jsonl
MADE = results/captures_made.jsonl
STARTS = 0 1 2 3 4 5 6 7
UNKNOWN = "the rule alone" tried
KNOWN = Nearest "targets known" "targets known, tried" "targets known, others tried"
EXAMPLES = $(addprefix $${FSEL_CAPTURES:-../shared/captures}/,batmobile helmet miku)
captures: .venv/installed
	$(CAPTURES)_unknown.py --methods $(UNKNOWN) --starts $(STARTS) --rows $(ROWS)
	$(CAPTURES)_unknown.py --methods $(KNOWN) --starts 1 3 5 7 --budgets 10 20 30 --seeds 1 --rows $(ROWS)
	$(CAPTURES)_unknown.py --made --methods tried --starts $(STARTS) --budgets 10 --rows $(MADE)
	$(CAPTURES)_unknown.py --made --methods tried --starts 0 2 4 6 --budgets 20 --rows $(MADE)
	$(CAPTURES)_unknown.py $(EXAMPLES) --made --methods tried --starts 0 2 4 6 --budgets 15 30 50 --rows $(MADE)
	$(CAPTURES)_page.py --rows $(ROWS) --made-rows $(MADE) -o docs/results/captures_unknown.md

# `fsel` with targets known over Nearest on the captures of config/real.yaml, five hours
.PHONY: real
HELD = every random region
SEEN = Nearest "targets known" "targets known, tried"
REAL = --starts 3 --by gaussians --methods $(SEEN) --rows results/real_
real: .venv/installed
	for held in $(HELD); do $(CAPTURES)_unknown.py --held $$held --budgets 8 $(REAL)$$held.jsonl || exit; done
	$(CAPTURES)_unknown.py --held random --budgets 20 30 $(REAL)random.jsonl
	$(CAPTURES)_page.py --known $(HELD:%=results/real_%.jsonl) -o docs/results/captures_known.md

# the same at 384 pixels, beside what tools pick by, four hours: docs/results/captures_384.md
.PHONY: captures_384
LARGE = results/captures_384.jsonl
AT_384 = --side 384 --by gaussians --seeds 1 --rows $(LARGE)
PRACTICE = "the rule alone" alicevision thumbnail warp_rf
captures_384: .venv/installed
	$(CAPTURES)_unknown.py $(AT_384) --starts 1 3 5 7 --budgets 10 --methods tried best_n Nearest "targets known"
	$(CAPTURES)_unknown.py $(AT_384) --starts 3 7 --budgets 20 30 --methods tried
	$(CAPTURES)_unknown.py $(AT_384) --starts 3 7 --budgets 10 --methods "targets known, tried"
	$(CAPTURES)_unknown.py $(AT_384) --starts 3 --budgets 20 30 --methods Nearest "targets known"
	$(CAPTURES)_unknown.py $(AT_384) --starts 3 --budgets 10 --methods $(PRACTICE)
	$(CAPTURES)_page.py --rows $(LARGE) -o docs/results/captures_384.md

# selections of real videos in FSEL_VIDEOS: docs/results/videos.md
.PHONY: videos
VIDEOS = OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 .venv/bin/python benchmarks/videos.py
videos: .venv/installed
	$(VIDEOS)
	$(VIDEOS) --paused --budgets 20 40 --methods uniform fsel --seeds 0 1
	$(VIDEOS) --side 384 --budgets 40 --methods uniform fsel --seeds 0 1

# every table and figure of the default run, hours, and its pages: docs/results/*.md
.PHONY: results
STUDIES = results/tables/speed_error.tex
results: .venv/installed
	.venv/bin/snakemake --cores $(CORES) all paper $(STUDIES)
	$(MAKE) docs

# write docs/results/*.md from the csv files of this checkout: docs/results/pages.yaml
docs: .venv/installed
	.venv/bin/python tools/result_pages.py
	.venv/bin/python tools/claims.py

# the script of the page of `fsel view`, by npm: src/fsel/pages/viewer/bundle.js
.PHONY: viewer
viewer: .venv/installed
	.venv/bin/python tools/viewer_bundle.py

# the pages of docs/ and a reference of the Python API, in site/; a warning is an error
.PHONY: site picture
site: .venv/site
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --quiet

# the first picture of README.md, five minutes, of a capture that its licence lets us show
picture: .venv/installed
	.venv/bin/python examples/side_by_side.py --clip docs/figures/side_by_side.webp \
		--capture $${FSEL_CAPTURES:-../shared/captures}/miku

# the rules of the default run, without arrows that others imply; `dot` and `tred` are graphviz's
rulegraph: .venv/installed
	.venv/bin/snakemake --rulegraph --workflow-profile none 2>/dev/null | tred \
		| dot -Grankdir=LR -Nfontname=sans-serif -Tsvg > docs/figures/rulegraph.svg

# compiled to bytecode at the first import: of torch and what it brings little is ever imported
.venv/installed: pyproject.toml
	$(PYTHON) -m venv .venv
	.venv/bin/python -m pip install --quiet --no-compile --editable '.[workflow]'
	touch $@

.venv/dev: .venv/installed
	.venv/bin/python -m pip install --quiet --no-compile --editable '.[workflow,dev]'
	touch $@

.venv/site: .venv/installed
	.venv/bin/python -m pip install --quiet --no-compile --editable '.[workflow,docs]'
	touch $@
