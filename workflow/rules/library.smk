"""The library as input: an edit reruns exactly what it may change."""

from functools import cache

from fsel.reconstruct import needs_gpu
from fsel.selector import pretrained
from fsel.workflow.dependencies import dependencies

LIBRARY = Path(os.path.relpath(Path(workflow.basedir, "src", "fsel")))


@cache
def needed(reconstructor):
    """Script -> files of the library that it needs with one reconstructor."""
    first = reconstructor == config["reconstruction"]["name"]
    try:
        return dependencies(
            LIBRARY,
            LIBRARY / "../../workflow/scripts",
            Path(
                ".snakemake",
                "library.json" if first else f"library_{reconstructor}.json",
            ),
            using={
                "fsel.reconstruct:RECONSTRUCTORS": [reconstructor],
                "fsel.metrics:REGISTERED": {"psnr", "ssim", "gmsd", *METRICS},
            },
        )
    except (ValueError, SyntaxError) as error:
        raise WorkflowError(
            f"{error}\nHint: the workflow's scripts or the library name it"
        )


def library(script, reconstructor=None):
    """Files of the library that a script in workflow/scripts needs, as inputs of its rule."""
    found = needed(reconstructor or config["reconstruction"]["name"])
    if script not in found:
        raise WorkflowError(
            f"there is no workflow/scripts/{script}.py\n"
            f"Hint: `library` takes the name of a script; there are {', '.join(found)}"
        )
    return [str(LIBRARY / path) for path in found[script]]


def check_scorers():
    """Refuse scorers of the config that are not there, or are none of their policy."""
    for policy, paths in config["training"]["weights"].items():
        for path in paths:
            try:
                pretrained.own(path, policy)
            except (ValueError, OSError) as error:
                refuse(
                    f"training.weights.{policy}: {error}",
                    "`fsel train` and the workflow write such files",
                )


if workflow.is_main_process:
    check_scorers()

# of the rules that reconstruct by the first reconstructor
GPU = int(needs_gpu(config["reconstruction"]))
