"""What the config names and is not here: reconstructors, weights, packages. Functions only."""

import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

sys.path.insert(0, str(Path(workflow.basedir, "src")))

from fsel.features import appearance
from fsel.metrics import lpips
from fsel.reconstruct import check_needs
from fsel.reconstruct.outcome import MissingRequirement

# a cluster's nodes have the GPUs that its login node lacks
ELSEWHERE = shutil.which("sbatch") is not None
STAND_INS = Path(workflow.basedir, "config", "stand_ins.yaml")


KEYS = "config/README.md describes the keys"


def absent(where, name, reconstruction):
    """What a reconstructor needs and is not here, a line each, the first of which says whose it is.

    What is wrong in itself is refused.
    """
    try:
        check_needs(reconstruction, devices=not ELSEWHERE)
    except MissingRequirement as error:
        return f"{where}, {name}: {error}".replace("\n", "\n  ").splitlines()
    except ValueError as error:
        refuse(f"{where}, {name}: {error}", KEYS)
    return []


def check_judges(judges, where):
    """Refuse reconstructors that cannot work here, before any job."""
    for name, reconstruction in judges.items():
        if lines := absent(where, name, reconstruction):
            refuse("\n".join(lines), KEYS)


def lacking():
    """What the run needs and is not here, a line each; what is wrong in itself is refused."""
    named = [("reconstruction", name, section) for name, section in JUDGES.items()]
    if LABELLED_BY != config["reconstruction"]:
        named.append(("search.reconstruction", "labels", LABELLED_BY))
    found = [line for each in named for line in absent(*each)]
    asked = [(appearance.check, config["appearance"])]
    if "lpips" in config["metrics"]:
        asked.append((lpips.located, config["lpips"]))
    for check, settings in asked:
        try:
            check(**settings)
        except (FileNotFoundError, ImportError) as error:
            found.append(str(error))
        except ValueError as error:
            refuse(str(error), KEYS)
    # a check ends at the file that it misses, and a page has all
    wanted = {
        "timm": config["appearance"]["kind"] == "dinov2",
        "lpips": "lpips" in config["metrics"],
    }
    missing = [name for name, asked in wanted.items() if asked and not find_spec(name)]
    if missing:
        found.append(f"packages {', '.join(missing)}: pip install 'fsel[weights]'")
    return found


def without():
    """How a run goes without what is lacking, and what it makes then."""
    given = [*map(os.path.relpath, workflow.configfiles), os.path.relpath(STAND_INS)]
    lines = [
        "without: `splats`, GMSD and `lab_hog` in the place of what is missing, by",
        f"  snakemake paper --cores 2 --configfile {' '.join(given)}",
    ]
    if config["training"]["dataset"] in MISSING:
        return [*lines, "  once the dataset of training.dataset is there"]
    made, left_out = papers()
    names = ", ".join(path.rsplit("/")[-1] for path in made)
    return [*lines, f"  which makes {names}", *left_out]


def check_all_is_here():
    """Refuse a run that lacks something, with one page of all of it."""
    if found := lacking():
        refuse(
            f"{len(found)} of what is named is not here:\n"
            + "\n".join([*(f"  {line}" for line in found), *without()]),
            "get each as it says; paths are from the folder of the run. docs/reconstructors.md "
            "has the licences",
        )
