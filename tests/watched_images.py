"""Images that remember which frames were opened."""

import numpy as np


class Watched:
    """Images that remember which of them were asked for."""

    def __init__(self, images):
        self.images, self.asked = images, set()
        self.ndim, self.dtype, self.shape = images.ndim, images.dtype, images.shape

    def __len__(self):
        return len(self.images)

    def __getitem__(self, frames):
        self.asked |= set(np.atleast_1d(frames).tolist())
        return self.images[frames]
