"""The script of the page for a wheel: `python -m fsel.viewer`, which `make viewer` runs."""

from fsel.viewer.bundle import SHIPPED, script

SHIPPED.write_text(script(), encoding="utf-8")
