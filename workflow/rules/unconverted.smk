"""What the rules that are not yet specs of `fsel.experiments` call: it goes with the last of them."""

import re
from functools import cache
from types import SimpleNamespace

from snakemake.exceptions import WorkflowError

import sys
from fsel.reconstruct import needs_gpu
from fsel.workflow import reconstructors
from fsel.workflow.refusal import Refusal, refuse
from fsel.workflow.requirements import check_reconstructors as check_judges
from fsel.workflow.resources import growing, per_capture
from fsel.workflow.resources import per_reconstruction as reconstruction_of_size

config["reconstruction"] = experiment.reconstruction
config["datasets"] = dict(experiment.datasets.entries)
config["search"].pop("reconstruction", None)
MISSING = experiment.datasets.missing
JUDGES = dict(experiment.reconstructors)
judges, judged_by = reconstructors.named, reconstructors.described
METRICS, TRAINED, LABELLED = experiment.metrics, experiment.trained, experiment.labelled
SEEDS, FSEL, SCORERS = experiment.seeds, experiment.fsel, experiment.scorers
OURS, PRACTISED = experiment.weights("less_is_more"), experiment.practised
GPU = int(needs_gpu(experiment.reconstruction))
scenes, labels, facts = experiment.scenes, experiment.labels, experiment.facts
scene_seed, generated = experiment.scene_seed, experiment.generated
evaluation_problems, budget_near = experiment.problems, experiment.budget_near
frames_needed, role_of = experiment.frames_needed, experiment.datasets.role_of
reading = experiment.datasets.reading


def per_reconstruction(amount):
    own = [s["long_side"] for s in JUDGES.values() if s["name"] != "external"]
    return reconstruction_of_size(amount, max(own, default=0))


@cache
def library(script, reconstructor=None):
    text = Path(workflow.basedir, "workflow", "scripts", f"{script}.py")
    if not text.exists():
        home = f"fsel.stages.{script}"
    else:
        (home,) = re.findall(
            r"^from (fsel\.[\w.]+) import \w+$",
            re.sub(r"^from fsel.workflow.*$", "", text.read_text(), flags=re.M),
            flags=re.M,
        )
    return experiment.library(home, reconstructor and {"name": reconstructor})


def raw_capture(wildcards):
    return experiment.datasets.raw_capture(wildcards.dataset, wildcards.scene)


def evaluation_scenes():
    return experiment.evaluation_scenes


def rooms():
    return inputs.rooms(experiment)


def passes(wildcards):
    return inputs.passes(experiment, wildcards)


def object_scenes():
    return inputs.object_scenes(experiment)


def of_objects(name):
    return lambda wildcards: inputs.of_scenes(object_scenes(), name)


def of_rooms(name):
    return lambda wildcards: inputs.of_scenes(rooms(), name)


def posed_twice():
    return inputs.posed_twice(experiment)


def of_posed_twice(name):
    return lambda wildcards: inputs.of_scenes(posed_twice(), f"sources/{name}")


def held_out_scenes():
    return [scene for _, scene in inputs.held_out_scenes(experiment)]


def of_held_out_scenes(name, draws=None):
    return lambda wildcards: inputs.of_scenes(
        inputs.held_out_scenes(experiment), name, draws
    )


def held_out_problems():
    return inputs.held_out_problems(experiment)


def of_held_out(name):
    return lambda wildcards: inputs.of_problems(held_out_problems(), name)


def first_scene(name):
    return lambda wildcards: (
        f"<results>/{wildcards.dataset}/{scenes(wildcards.dataset, 'evaluation')[0]}/{name}"
    )


def first_scenes():
    return inputs.first_scenes(experiment)


def of_posed(name):
    return inputs.of_scenes(first_scenes(), f"poses/{name}")


def frames_to_place():
    return 2 * config["targets"] + budget_near(30)


def large_capture(wildcards):
    frames = config["inexact_poses"]["frames"]
    if frames < frames_to_place():
        refuse(
            f"inexact_poses.frames is {frames}, the experiment needs {frames_to_place()}: targets, as "
            f"many proxies, and a budget of {budget_near(30)}",
            "raise inexact_poses.frames, or lower targets or budgets",
        )
    if "embedded" in config["datasets"][wildcards.dataset]:
        return f"<results>/{wildcards.dataset}/{wildcards.scene}/poses/data"
    return raw_capture(wildcards)
