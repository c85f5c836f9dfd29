"""The library as input: an edit reruns exactly what it may change."""

import sys

LIBRARY = Path(os.path.relpath(Path(workflow.basedir, "src", "fsel")))
sys.path.insert(0, str(Path(workflow.basedir, "src")))

from fsel.stages.dependencies import dependencies

try:
    NEEDED = dependencies(
        LIBRARY,
        LIBRARY / "../../workflow/scripts",
        Path(".snakemake", "library.json"),
        using={
            "fsel.reconstruct:RECONSTRUCTORS": [config["reconstruction"]["name"]],
            "fsel.metrics:REGISTERED": {"psnr", "ssim", "gmsd", *METRICS},
        },
    )
except (ValueError, SyntaxError) as error:
    raise WorkflowError(f"{error}\nHint: the workflow's scripts or the library name it")

if "lpips" in METRICS:
    from fsel.metrics.lpips import located

    try:
        located(**METRICS["lpips"])
    except (ValueError, FileNotFoundError, ImportError) as error:
        raise WorkflowError(f"config: {error}")


def library(script):
    """Files of the library that a script in workflow/scripts needs, as inputs of its rule."""
    if script not in NEEDED:
        raise WorkflowError(
            f"there is no workflow/scripts/{script}.py\n"
            f"Hint: `library` takes the name of a script; there are {', '.join(NEEDED)}"
        )
    return [str(LIBRARY / path) for path in NEEDED[script]]
