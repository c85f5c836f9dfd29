"""Outputs as the report shows them, and inputs that are no results."""


def shown(name, title, category="Paper", folder="{reconstructor}", **paths):
    """The outputs of a table or figure, those of `inputs.SHOWN` with a place in the report.

    Args:
        name: of a table's files, and of the file in `workflow/report` with the caption.
        title: of the table or figure.
        category: a heading of the report.
        folder: of a table's files; by default that of each reconstructor.
        paths: name -> path or paths; with `figures`, all outputs, else those besides a table.
    """
    if "figures" not in paths:
        paths = inputs.table_files(folder + name) | paths
    for kind in inputs.SHOWN:
        if kind in paths:
            labels = inputs.report_labels(title, kind)
            caption = f"../report/{name}.rst"
            paths[kind] = report(paths[kind], caption, category, labels=labels)
    return paths


def kept_here(choose):
    """An input function that reads what is no result where Snakemake runs, in no storage.

    Args:
        choose: function of the wildcards that returns a path.
    """

    def path(wildcards):
        chosen = choose(wildcards)
        return chosen if chosen.startswith("<results>") else local(chosen)

    return path
