"""The workflow's stages, one file each.

Jobs of stages and of experiments name what they share alike; a docstring tells the rest.

- `folder`, `folders`: canonical captures, with their descriptors where something is selected.
- `split`, `splits`: split.parquet of a draw, one a draw or one a capture.
- `weights`: scorers of the learned methods. `picks`, `evaluation`, `evaluations`: what the jobs
  wrote that select and that measure, one a scene or problem.
- `table`, `numbers`, `figures`: receive LaTeX, its numbers as csv, and figures, whose endings
  choose the format.
- `scenes`, `problems`: dataset and scene of each file, or `dataset/scene/draw0`; `datasets`: name
  -> printed label, in order.
- `budgets`, `k`: frames to pick; `draws`: of targets; `seed`, `seeds`: of the scene, of its draws.
- `reconstruction`, `appearance`, `search`, `auto`: sections of the configuration; `metrics`: names,
  or name -> settings, in a cell's order; `facts`: what a caption tells, see
  `fsel.evaluation.latex`.
- `config`: digest of the parameters, which tables carry; `inputs`: files that evaluations depend
on.
"""
