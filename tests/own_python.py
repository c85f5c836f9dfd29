"""Programs in a Python of their own."""

import os
import subprocess
import sys


def printed(code, *arguments, folder=None, **variables):
    """What a program prints, which must end well."""
    run, variables = [sys.executable, "-c", code, *map(str, arguments)], os.environ | variables
    done = subprocess.run(run, cwd=folder, env=variables, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout
