"""The checked config, and every function that the rules use."""

import os
import re
import zlib
from pathlib import Path
from types import SimpleNamespace

from snakemake.exceptions import WorkflowError
from snakemake.utils import validate

ROLES = ("train", "validation", "evaluation", "object")
READING = {
    "focal": "tanks_and_temples",
    "instance": "scannet",
    "min_quality": "co3d",
    "pose_source": "seven_scenes",
}
# every evaluation makes and drops arrays of megabytes: glibc would hand their pages back to the
# kernel each time and ask for them anew, 8 % of a search; bytes, inherited by every job
for threshold in ("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"):
    os.environ.setdefault(threshold, str(32 << 20))


def refuse(message, hint):
    raise WorkflowError(f"config: {message}\nHint: {hint}")


try:
    validate(config, "../schemas/config.schema.yaml")
except WorkflowError as error:
    fault = error.__context__
    keys = sorted(fault.schema.get("properties", {}))
    refuse(
        f"{fault.json_path.removeprefix('$.').replace('$', 'top level')}: {fault.message}",
        (f"the keys here are {keys}; " if keys else "")
        + "config/README.md describes every key",
    )


def judges(reconstructions, where):
    """Name -> section of each configured reconstructor, in order."""
    found = {}
    for section in reconstructions:
        name = section.get("as", section["name"])
        if name in found:
            refuse(
                f"{where} has two named {name!r}", "`as` gives one of them another name"
            )
        found[name] = {k: v for k, v in section.items() if k != "as"}
    return found


def judged_by(name, reconstruction):
    """What a caption tells of a reconstructor."""
    own = reconstruction["name"]
    return {
        "reconstructor": own if own == name else f"{name} ({own})",
        "long_side": reconstruction["long_side"],
    }


given = config["reconstruction"]
JUDGES = judges(given if isinstance(given, list) else [given], "reconstruction")
# the rules of one reconstructor have the first: it labels, and judges in every table
config["reconstruction"] = next(iter(JUDGES.values()))
# labels are searched by another where one is named
LABELLED_BY = config["search"].pop("reconstruction") or config["reconstruction"]
LABELLED_BY = {k: v for k, v in LABELLED_BY.items() if k != "as"}


# `paper` and tables asked for by name go without datasets that are not there; `all` refuses
CONFIGURED = dict(config["datasets"])
MISSING = missing_roots()
config["datasets"] = {n: d for n, d in CONFIGURED.items() if n not in MISSING}


def scenes(dataset, role):
    """Names of a dataset's scenes with a role, in order."""
    entry = config["datasets"][dataset]["scenes"]
    if isinstance(entry, list):
        entry = {"evaluation": entry}
    found = entry.get(role, [])
    if not isinstance(found, int):
        return found
    if "embedded" in config["datasets"][dataset]:
        return [f"{role}{number:02d}" for number in range(found)]
    return counted(dataset, role)


def check_dataset(name, dataset):
    """Refuse an entry that no job could serve."""
    where = f"datasets.{name}"
    if sum(kind in dataset for kind in KINDS) != 1:
        refuse(
            f"{where} needs exactly one of `embedded`, `root` and `fetch`, got {sorted(dataset)}",
            "`embedded: {family: ...}` generates captures, `root: folder` reads them from disk, "
            "`fetch: source` downloads them",
        )
    if "fetch" in dataset:
        check_source(where, dataset)
    entry = dataset["scenes"] if isinstance(dataset["scenes"], dict) else {}
    numbers = {isinstance(given, int) for given in entry.values()}
    if len(numbers) > 1 or ("embedded" in dataset and numbers != {True}):
        refuse(
            f"{where}.scenes is {dataset['scenes']}",
            "embedded datasets take a number of scenes for every role, others that or names",
        )
    named = [scene for role in ROLES for scene in scenes(name, role)]
    if len(set(named)) < len(named):
        refuse(
            f"{where}.scenes names a scene twice: {named}", "give each scene one role"
        )
    if "embedded" in dataset and dataset["layout"] == "auto":
        refuse(
            f"{where}.layout is `auto`",
            "name the layout that embedded captures are written in",
        )
    check_reading(where, dataset)
    check_objects(where, name, dataset)
    if "root" in dataset:
        check_folders(where, Path(dataset["root"]), named)
    if "fetch" in dataset:
        check_fetched(where, dataset, named)


def check_reading(where, dataset):
    """Refuse what the layout's reader would refuse later."""
    if (dataset["poses"] == "file") != ("model" in dataset):
        refuse(
            f"{where}.poses is {dataset['poses']!r} and model {dataset.get('model')!r}",
            "`poses: file` needs `model`, a folder inside each scene, and nothing else does",
        )
    for key in dataset["reading"]:
        if dataset["layout"] not in ("auto", READING[key]):
            refuse(
                f"{where}.reading.{key}: layout {dataset['layout']} does not take it",
                f"only {READING[key]} does",
            )


def reading(name, scene):
    """How a scene is read; where every scene has an object of its own, which one."""
    keys = (
        "layout",
        "poses",
        "model",
        "points",
        "every",
        "max_error",
        "reading",
    )
    dataset = config["datasets"][name]
    found = {key: dataset[key] for key in keys if key in dataset}
    instance = dataset["reading"].get("instance")
    if isinstance(instance, dict):
        others = {k: v for k, v in dataset["reading"].items() if k != "instance"}
        own = {"instance": instance[scene]} if scene in instance else {}
        found["reading"] = others | own
    return found


def check_objects(where, name, dataset):
    """Refuse ScanNet scenes of which nobody says what the object is."""
    instance = dataset["reading"].get("instance", {})
    if dataset["layout"] == "scannet" and isinstance(instance, dict):
        missing = [s for s in scenes(name, "object") if s not in instance]
        if missing:
            refuse(
                f"{where}.reading.instance: no object of {missing}",
                "give the value in instance-filt of the object, one for all or one a scene",
            )


def check_folders(where, root, named):
    missing = [scene for scene in named if not (root / scene).is_dir()]
    if missing:
        present = sorted(path.name for path in root.iterdir() if path.is_dir())
        refuse(
            f"{where}.scenes: no folders {missing} in {root}",
            f"the folders there are {present}",
        )


def check_search():
    """Refuse numbers of a search that do not fit together."""
    search = config["search"]
    if search["kept"] > search["stored"]:
        refuse(
            f"search: kept is {search['kept']}, more than stored, {search['stored']}",
            "only stored subsets can be imitated",
        )
    if search["farthest"] + search["uniform"] > search["population"]:
        refuse(
            f"search: farthest and uniform are {search['farthest']} and "
            f"{search['uniform']}, more than population, {search['population']}",
            "the rest of the first generation is random",
        )


def check_experiment():
    """Refuse what would only fail after hours of work."""
    trained = config["training"]["dataset"]
    if trained in MISSING or not config["datasets"]:
        check_roots()
    for name, dataset in config["datasets"].items():
        check_dataset(name, dataset)
    if trained not in config["datasets"] or not scenes(trained, "train"):
        refuse(
            f"training.dataset is {trained!r}, which has no `train` scenes among the datasets "
            f"{list(config['datasets'])}",
            f"add `{trained}` with train scenes, or name another dataset",
        )
    check_search()
    if not any(scenes(name, "evaluation") for name in config["datasets"]):
        refuse("no dataset has evaluation scenes", "the tables need at least one")
    for name, dataset in config["datasets"].items():
        for role in ROLES:
            needed, frames = frames_needed(role), config["embedded"]["frames"]
            if "embedded" in dataset and scenes(name, role) and frames < needed:
                refuse(
                    f"embedded.frames is {frames}, the {role} scenes of {name} need {needed}: "
                    "targets, as many proxies, and the largest budget",
                    "raise embedded.frames, or lower targets or budgets",
                )


def complete(wildcards):
    """Input function of no file: refuses to go without a dataset of the config."""
    if MISSING:
        check_roots()
    return []


def frames_needed(role):
    """Least frames of a scene: targets, their proxies, and candidates for the largest budget."""
    if role == "evaluation":
        return 2 * config["targets"] + max(
            max(config["budgets"]), config["search"]["k"]
        )
    if role == "object":
        return 2 * config["targets"] + budget_near(30)
    labels = (
        2 * max(4, int(0.15 * max(config["coverages"]) + 0.5)) + config["search"]["k"]
    )
    refinement = config["refinement"]
    if not refinement["seeds"]:
        return labels
    return max(labels, 2 * refinement["targets"] + max(refinement["budgets"]))


def role_of(dataset, scene):
    return next(role for role in ROLES if scene in scenes(dataset, role))


def raw_capture(wildcards):
    """Folder of a scene as its dataset is distributed."""
    dataset = config["datasets"][wildcards.dataset]
    if "root" in dataset:
        return str(Path(dataset["root"], wildcards.scene))
    return f"<results>/data/{wildcards.dataset}/{wildcards.scene}"


def scene_seed(wildcards, *parts):
    """A seed from names, so that adding a scene changes no other."""
    names = [config["seed"], wildcards.dataset, wildcards.scene, *parts]
    return zlib.crc32("/".join(map(str, names)).encode())


def generated(dataset, scene):
    """What made an embedded capture, from which its exact depth is cast; None for others."""
    entry = config["datasets"][dataset]
    if "embedded" not in entry:
        return None
    return {
        "family": entry["embedded"]["family"],
        "seed": scene_seed(SimpleNamespace(dataset=dataset, scene=scene)),
        "recorded": config["embedded"]["frames"],
    }


def training_seed(wildcards):
    return zlib.crc32(
        f"{config['seed']}/{config['training']['dataset']}/{wildcards.scene}".encode()
    )


def evaluation_scenes():
    """(dataset, scene) of every evaluation scene."""
    return [(d, scene) for d in config["datasets"] for scene in scenes(d, "evaluation")]


def evaluation_problems(draws):
    """dataset/scene/draw of every evaluation problem with a draw below a number."""
    return [f"{d}/{s}/draw{n}" for d, s in evaluation_scenes() for n in range(draws)]


def labels():
    """Labels of the datasets in the tables."""
    datasets = config["datasets"]
    return {
        name: datasets[name]["label"] for name in datasets if scenes(name, "evaluation")
    }


def shared_places():
    """dataset/scene -> place of evaluation scenes that may share one with another."""
    found = {}
    for d, s in evaluation_scenes():
        given = config["datasets"][d].get("places", {})
        shared = f"{given}/{s}" if isinstance(given, str) else given.get(s)
        if shared is not None:
            found[f"{d}/{s}"] = shared
    return found


def facts(names=None):
    """What a caption tells of the captures (of some datasets; of all without) and the settings."""
    names = labels() if names is None else names
    datasets = {name: config["datasets"][name] for name in names}
    return {
        "embedded": [d["label"] for d in datasets.values() if "embedded" in d],
        "real": [d["label"] for d in datasets.values() if "embedded" not in d],
        **judged_by(*next(iter(JUDGES.items()))),
        "descriptor": config["appearance"]["kind"],
        "search_k": config["search"]["k"],
        "draws": config["draws"],
        "oracle_draws": config["oracle"]["draws"],
        "places": shared_places(),
        "oracle_dataset": config["datasets"][config["training"]["dataset"]]["label"],
    }


def rooms():
    """(dataset, scene) of the evaluation scenes filmed in several passes."""
    held_out = config["crosscapture"]["held_out"]
    found = [
        (d, s)
        for d, s in evaluation_scenes()
        if (
            s in held_out.get(d, {})
            if held_out
            else config["datasets"][d].get(
                "passes", config["datasets"][d]["layout"] == "seven_scenes"
            )
        )
    ]
    asked = {f"{d}/{s}" for d in held_out for s in held_out[d] if d not in MISSING}
    if unknown := sorted(asked - {"/".join(room) for room in found}):
        refuse(
            f"crosscapture.held_out: {unknown} are no evaluation scenes",
            "it names datasets, their scenes, and passes of each",
        )
    if not found:
        refuse(
            "no dataset with evaluation scenes was filmed in several passes",
            "the cross-capture experiment needs layout seven_scenes, a dataset with `passes: true`, "
            "or crosscapture.held_out",
        )
    return found


def passes(wildcards):
    """The passes of a room that are held out in turn; none for each of all."""
    named = config["crosscapture"]["held_out"].get(wildcards.dataset, {})
    return named.get(wildcards.scene, [])


def object_scenes():
    """(dataset, scene) of every capture that is about an object."""
    found = [(d, s) for d in config["datasets"] for s in scenes(d, "object")]
    if not found:
        refuse(
            "no dataset has `object` scenes",
            "the object-centric experiment needs captures with masks of an object",
        )
    return found


def of_objects(name):
    """Input function: a file of every capture that is about an object."""
    return lambda wildcards: [f"<results>/{d}/{s}/{name}" for d, s in object_scenes()]


def datasets_with_objects():
    """Pattern of the names of datasets with masks of objects; it matches nothing without any."""
    names = [re.escape(name) for name in config["datasets"] if scenes(name, "object")]
    return "|".join(names) or "(?!)"


def of_rooms(name):
    """Input function: a file of every room."""
    return lambda wildcards: [f"<results>/{d}/{s}/{name}" for d, s in rooms()]


def posed_twice():
    """(dataset, scene) of the evaluation scenes with a second source of poses."""
    named = config["pose_sources"]["dataset"]
    if named is None or named in MISSING:
        refuse(
            f"pose_sources.dataset is {named}"
            + (", which is not there" if named else ""),
            "name a dataset on disk, and in `model` the folder of a COLMAP model inside each "
            "scene, such as another estimator's export",
        )
    if "root" not in config["datasets"].get(named, {}):
        refuse(
            f"pose_sources.dataset is {named!r}, no dataset with a `root`",
            "a second source of poses is a folder inside each scene",
        )
    model, root = config["pose_sources"]["model"], config["datasets"][named]["root"]
    found = scenes(named, "evaluation")
    if missing := [s for s in found if not Path(root, s, model).is_dir()]:
        refuse(
            f"pose_sources.model is {model!r}, no folder in {len(missing)} of {len(found)} scenes "
            f"of {named}: {missing[:3]}",
            "export the second source's poses as a COLMAP model there",
        )
    return [(named, scene) for scene in found]


def of_posed_twice(name):
    """Input function: a file of every scene with a second source of poses."""
    return lambda wildcards: [
        f"<results>/{d}/{s}/sources/{name}" for d, s in posed_twice()
    ]


def held_out_scenes():
    """Evaluation scenes of the training dataset."""
    found = scenes(TRAINED, "evaluation")
    if not found:
        refuse(
            f"{TRAINED} has no evaluation scenes",
            "this experiment is made on evaluation scenes of training.dataset",
        )
    return found


def of_held_out_scenes(name, draws=()):
    """Input function: a file of every held-out scene, or of each of its draws."""
    middle = [f"draw{n}/" for n in draws] or [""]
    return lambda wildcards: [
        f"<results>/{TRAINED}/{scene}/{part}{name}"
        for scene in held_out_scenes()
        for part in middle
    ]


def searched_problems():
    """Problems of the training dataset's evaluation scenes that the search is run on, if any."""
    return [
        f"{TRAINED}/{s}/draw{n}"
        for s in scenes(TRAINED, "evaluation")
        for n in range(config["oracle"]["draws"])
    ]


def held_out_problems():
    """The same, at least one, where selections are compared with the search."""
    found = searched_problems()
    if not found:
        refuse(
            f"{TRAINED} has no evaluation scenes, or oracle.draws is 0",
            "the comparison with the search is made on evaluation scenes of training.dataset",
        )
    if config["search"]["k"] not in config["budgets"]:
        refuse(
            f"search.k is {config['search']['k']}, which is not among budgets {config['budgets']}",
            "selections are compared with the search at its own budget",
        )
    return found


def of_held_out(name):
    """Input function: a file of every problem in `held_out_problems`."""
    return lambda wildcards: collect(
        "<results>/{problem}/{name}", problem=held_out_problems(), name=name
    )


def budget_near(k):
    """The largest budget up to a number of frames, or the smallest."""
    return max([b for b in config["budgets"] if b <= k] or [min(config["budgets"])])


def first_scene(name):
    """Input function: a file of the first evaluation scene of the wildcard `dataset`."""
    return lambda wildcards: (
        f"<results>/{wildcards.dataset}/{scenes(wildcards.dataset, 'evaluation')[0]}/{name}"
    )


def first_scenes():
    """(dataset, scene) of every dataset's first evaluation scene."""
    return [(d, scenes(d, "evaluation")[0]) for d in labels()]


def of_posed(name):
    """A file of every scene on which poses are estimated and disturbed."""
    return [f"<results>/{d}/{s}/poses/{name}" for d, s in first_scenes()]


def frames_to_place():
    """Least frames whose poses must be found: targets, their proxies, candidates to select."""
    return 2 * config["targets"] + budget_near(30)


def large_capture(wildcards):
    """The scene with images large enough to be matched: embedded ones are filmed anew."""
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


check_experiment()

METRICS = {m: config["lpips"] if m == "lpips" else {} for m in config["metrics"]}
# of searches: another metric in the tables changes no label and no selector
FITNESS = {
    m: METRICS.get(m, {})
    for m in ("psnr", "ssim", "lpips" if "lpips" in METRICS else "gmsd")
}
TRAINED = config["training"]["dataset"]
LABELLED = {s: r for r in ("train", "validation") for s in scenes(TRAINED, r)}
SEEDS = range(config["training"]["seeds"])


def scorers(policy, folder):
    """Scorers of a policy: files that the config names, or one trained here for each seed."""
    named = config["training"]["weights"].get(policy)
    return named or collect(f"{folder}/seed{{seed}}.safetensors", seed=SEEDS)


OURS = scorers("less_is_more", "<results>/selector")


def shipped(name):
    """A scorer that comes with the package."""
    return os.path.relpath(Path(workflow.basedir, "src/fsel/selector/weights", name))


# refined here, or the rule that comes with the package
FSEL = collect(
    "<results>/selector/fsel/seed{seed}.json",
    seed=range(config["refinement"]["seeds"]),
) or [
    shipped("fsel.json"),
]
SCORERS = [
    *OURS,
    *scorers("less_is_more_no_appearance", "<results>/selector/no_appearance"),
    *FSEL,
    shipped("fsel_rule.json"),
]
PRACTISED = [
    f"{d}/{s}"
    for d in config["datasets"]
    for s in scenes(d, "train")[: config["refinement"]["scenes"]]
]


wildcard_constraints:
    dataset="|".join(map(re.escape, config["datasets"])),
    scene=r"[^/]+",
    draw=r"\d+",
    seed=r"\d+",
