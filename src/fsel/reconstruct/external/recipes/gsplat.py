"""The trainer of gsplat (Ye et al. 2025), `examples/simple_trainer.py` of its repository, served.

    python gsplat.py EXAMPLES [default|mcmc] [KEY=VALUE ...]

Run in an environment with gsplat and what its examples require, on a GPU. EXAMPLES is the folder of
the clone that has simple_trainer.py; KEY is a field of its `Config`, VALUE is Python. The trainer
normalises the world by the cameras that it is given, the selected ones; the targets follow.
"""

import ast
import os
import sys

import numpy as np
import torch
from fsel_worker import camera_matrices, camera_to_world, serve

# what the trainer's own subcommand `mcmc` sets, where no import finds it
MCMC = {"init_opa": 0.5, "init_scale": 0.1, "opacity_reg": 0.01, "scale_reg": 0.01}


def main(examples, strategy="default", *given):
    """Serve it."""
    sys.path[0] = os.path.abspath(examples)  # this file has gsplat's name
    import gsplat
    import simple_trainer
    from gsplat.strategy import DefaultStrategy, MCMCStrategy

    kind, preset = {"default": (DefaultStrategy, {}), "mcmc": (MCMCStrategy, MCMC)}[strategy]
    stated = (word.split("=", 1) for word in given)
    own = preset | {key: ast.literal_eval(text) for key, text in stated}

    def fit(subset):
        settings = {"data_factor": 1, "disable_viewer": True, "disable_video": True}
        settings.update(eval_steps=[], save_steps=[], ply_steps=[], **own)
        settings["result_dir"] = os.path.join(subset.folder, "gsplat")
        config = simple_trainer.Config(
            data_dir=subset.folder, strategy=kind(verbose=False), **settings
        )
        runner = simple_trainer.Runner(0, 0, 1, config)
        runner.trainset.indices = np.arange(len(subset.images))  # it would hold every n-th out
        runner.train()
        runner.writer.close()  # a thread and a file of its events
        return Trained(runner)

    @torch.no_grad()
    def render(trained, views):
        poses = trained.transform @ camera_to_world(views.world_to_camera)
        poses[:, :3, :3] /= np.linalg.norm(poses[:, :1, :3], axis=2, keepdims=True)
        lenses, runner, images = camera_matrices(views.intrinsics), trained.runner, []
        for row in range(len(views)):
            camera = [
                torch.tensor(found[row : row + 1], dtype=torch.float32, device=runner.device)
                for found in (poses, lenses)
            ]
            degree = runner.cfg.sh_degree
            colors, _, _ = runner.rasterize_splats(*camera, *views.size, sh_degree=degree)
            images.append(colors[0, ..., :3].clamp(0, 1).cpu().numpy())
        return np.stack(images)

    serve(fit, render, name="gsplat", version=gsplat.__version__, device="cuda", needs=["files"])


class Trained:
    """Remains of a run: the runner, its world, and how many Gaussians."""

    def __init__(self, runner):
        self.runner, self.transform = runner, runner.parser.transform
        self.primitives = len(runner.splats["means"])


if __name__ == "__main__":
    main(*sys.argv[1:])
