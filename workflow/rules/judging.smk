"""Which reconstructors judge the picks: functions only."""

FURTHER = list(JUDGES)[1:]
COMPARED_DRAWS = range(min(config["draws"], config["transfer"]["draws"]))


def judge_of(wildcards):
    if wildcards.judge not in FURTHER:
        refuse(
            f"reconstruction: {wildcards.judge!r} is not among the further ones, {FURTHER}",
            "the tables of the first one are not in a folder of its name",
        )
    return JUDGES[wildcards.judge]


def judge_facts(wildcards, names=None):
    return facts(names) | judged_by(wildcards.judge, judge_of(wildcards))


def by_judge(files):
    """Input function: what another one names, in a folder of the reconstructor beside it."""
    return lambda wildcards: [
        str(Path(path).parent / wildcards.judge / Path(path).name)
        for path in files(wildcards)
    ]


@cache
def compared():
    """Name -> section of each reconstructor of `transfer`, once it is known to work here."""
    found = judges(config["transfer"]["reconstructions"], "transfer.reconstructions")
    if workflow.is_main_process:
        check_judges(found, "transfer.reconstructions")
    return found


def compared_budgets(key):
    """Budgets of which picks exist."""
    asked = config["transfer"][key]
    if missing := [k for k in asked if k not in config["budgets"]]:
        refuse(
            f"transfer.{key} has {missing}, which are not among budgets {config['budgets']}",
            "nothing is selected for these tables; picks of the sweep are taken",
        )
    return asked


def compared_everywhere():
    """Both tables' budgets, refused where picks do not exist."""
    return [compared_budgets("budgets"), compared_budgets("inputs")]


def compared_by(wildcards):
    if wildcards.judge not in compared():
        refuse(
            f"transfer.reconstructions has no {wildcards.judge!r}",
            f"its names are {list(compared())}",
        )
    return compared()[wildcards.judge]


def of_compared(name, draws):
    """Input function: a file of every reconstructor, held-out scene and draw."""
    return lambda wildcards: [
        f"<results>/{TRAINED}/{scene}/draw{n}/{judge}/{name}"
        for judge in compared()
        for scene in held_out_scenes()
        for n in draws
    ]


def compared_facts():
    return {name: judged_by(name, section) for name, section in compared().items()}
