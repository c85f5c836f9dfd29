#!/usr/bin/env bash
# The library of the clone that the workflow lies in, or the release that runs it.
set -euo pipefail
python -m pip install "$FSEL"
