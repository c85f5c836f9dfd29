"""The script of the page for a wheel: `python -m fsel.pages.viewer`, which `make viewer` runs."""

from fsel.pages.viewer.bundle import SHIPPED, script

SHIPPED.write_text(script(), encoding="utf-8")
