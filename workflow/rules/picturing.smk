"""What figures of rendered views are made of: functions only."""

PICTURES = {k: v for k, v in config["pictures"].items() if k != "as"}


@cache
def pictured():
    """The reconstructor of the pictures, once it is known to work here."""
    if workflow.is_main_process:
        check_judges({PICTURES["name"]: PICTURES}, "pictures")
    return PICTURES


def filmed_size():
    """Width and height of embedded captures that are filmed anew for pictures."""
    embedded, long_side = config["embedded"], PICTURES["long_side"]
    scale = long_side / max(embedded["width"], embedded["height"])
    return [round(scale * embedded[side]) for side in ("width", "height")]


def pictured_capture(wildcards):
    """The scene with images large enough for pictures: embedded ones are filmed anew."""
    if "embedded" in config["datasets"][wildcards.dataset]:
        return f"<results>/{wildcards.dataset}/{wildcards.scene}/pictures/data"
    return raw_capture(wildcards)


def pictured_facts(names):
    return facts(names) | judged_by(PICTURES["name"], PICTURES)


def first_place(name):
    """Input function: a file of the first place filmed in several passes."""
    return lambda wildcards: "<results>/{}/{}/{}".format(*rooms()[0], name)
