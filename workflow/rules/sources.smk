"""Where the captures of a dataset come from; functions only."""

import re
from functools import cache
from pathlib import Path

import yaml
from snakemake.utils import validate

KINDS = ("embedded", "root", "fetch")


@cache
def load_sources():
    """The table of pages and archives."""
    path = config["sources"] or Path(workflow.basedir, "config", "sources.yaml")
    with open(path, encoding="utf-8") as file:  # whose name errors tell
        found = yaml.safe_load(file)
    validate(found, "../schemas/sources.schema.yaml")
    return found


def where_from(dataset):
    """How to get a dataset that is not there, in words."""
    source = load_sources().get(dataset["layout"])
    if source is None:
        return ""
    return f"; {source['page']}, expected below root: {source['expects']}"


def missing_roots():
    """Name -> of each dataset whose root is not set or not there: what is, and where to get it."""
    return {
        name: f"datasets.{name}.root {dataset['root'] or 'is not set'}{where_from(dataset)}"
        for name, dataset in config["datasets"].items()
        if "root" in dataset
        and not (dataset["root"] and Path(dataset["root"]).is_dir())
    }


def check_roots():
    """Refuse all roots that are not set or not there together, saying where each comes from."""
    if MISSING:
        absent = lacking()
        others = (
            [f"and {len(absent)} of what else is named is not here:"] if absent else []
        )
        refuse(
            f"no folders (from {Path.cwd()}) for {len(MISSING)} of {len(CONFIGURED)} datasets:\n"
            + "\n".join(
                [
                    *(f"  {reason}" for reason in MISSING.values()),
                    *others,
                    *(f"  {line}" for line in absent),
                    *(without() if absent else []),
                ]
            ),
            "put each dataset there, correct the path, or leave its entry out; `snakemake paper` "
            "makes what can be made without",
        )


def check_source(where, dataset):
    """Refuse a source that may not be fetched by a program."""
    sources = load_sources()
    source = sources.get(dataset["fetch"], {"scenes": {}, "page": "", "expects": ""})
    offered = [name for name in sources if sources[name]["scenes"]]
    if not source["scenes"]:
        refuse(
            f"{where}.fetch is {dataset['fetch']!r}, which may not be downloaded by a program",
            (
                f"get it from {source['page']}, put it as {source['expects']} below a folder, and "
                "name that folder as `root`"
                if source["page"]
                else f"these may: {offered}"
            ),
        )


def check_fetched(where, dataset, named):
    """Refuse scenes that the source does not offer."""
    source = load_sources()[dataset["fetch"]]
    if missing := sorted(set(named) - set(source["scenes"])):
        refuse(
            f"{where}.scenes: {missing} are not among what may be fetched of {dataset['fetch']}",
            f"these are: {sorted(source['scenes'])}; the others are at {source['page']}",
        )


def found_on_disk(dataset):
    """Names of a dataset's scenes, in natural order: folders below its root, or what is fetched."""
    if "fetch" in dataset:
        return list(load_sources()[dataset["fetch"]]["scenes"])
    names = [path.name for path in Path(dataset["root"]).iterdir() if path.is_dir()]
    return sorted(
        (name for name in names if not name.startswith(".")),
        key=lambda name: [
            (int(part), "") if part.isdigit() else (-1, part)
            for part in re.split(r"(\d+)", name)
            if part
        ],
    )


def counted(name, role):
    """Scenes of a dataset that gives numbers: evaluation, validation, train, object."""
    dataset = config["datasets"][name]
    numbers, start = dataset["scenes"], 0
    for earlier in ("evaluation", "validation", "train", "object"):
        stop = start + numbers.get(earlier, 0)
        if earlier == role:
            break
        start = stop
    present = found_on_disk(dataset)
    if stop > len(present):
        refuse(
            f"datasets.{name}.scenes asks for {sum(numbers.values())} scenes, {len(present)} "
            "are there",
            "lower the numbers, or name the scenes",
        )
    return present[start:stop]


def archive_of(dataset, scene):
    """File name of the archive that holds a fetched scene."""
    source = config["datasets"][dataset]["fetch"]
    url = load_sources()[source]["scenes"][scene]["url"]
    return f"{source}_{url.rsplit('/', 1)[-1]}"


def archive(name):
    """Address and checksum of an archive, by its file name."""
    for source, entry in load_sources().items():
        for scene in entry["scenes"].values():
            if name == f"{source}_{scene['url'].rsplit('/', 1)[-1]}":
                return {"url": scene["url"], "sha256": scene["sha256"]}


def inside(dataset, scene):
    """Folder of a scene in its archive."""
    return load_sources()[config["datasets"][dataset]["fetch"]]["scenes"][scene][
        "inside"
    ]


def datasets_with(kind):
    """Pattern of the names of datasets of a kind; it matches nothing where there are none."""
    names = [re.escape(n) for n, entry in config["datasets"].items() if kind in entry]
    return "|".join(names) or "(?!)"
