"""Selection methods without training: one file each, one contract (see `fsel.problem`)."""

from fsel.baselines import all_frames, fvs, nearest, random_, uniform, untrained
from fsel.problem import Method

METHODS: dict[str, Method] = {
    module.METHOD.name: module.METHOD
    for module in (random_, uniform, fvs, nearest, untrained, all_frames)
}
