#!/usr/bin/env bash
# Runs in the folder that snakemake was started from: the repository.
set -euo pipefail
python -m pip install --editable '.[workflow]'
