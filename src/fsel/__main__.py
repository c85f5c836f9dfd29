"""`python -m fsel`: the command line."""

import sys

from fsel.cli import main

sys.exit(main())
