"""The default reconstructor: pixel-aligned splats from multi-view stereo, on the CPU.

Matching costs and depth maps are cached, since a search meets the same pairs of frames again.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.geometry import invert_pose
from fsel.core.threads import ranges, spread
from fsel.reconstruct import ply
from fsel.reconstruct.configured import ConfiguredReconstructor, Fitted, Peak
from fsel.reconstruct.selected import Frame, distinct
from fsel.reconstruct.splats import fusion, planes, render, stereo
from fsel.reconstruct.splats.fusion import Maps, agreed
from fsel.reconstruct.splats.planes import FrameCache, remember

MAX_PARTNERS = 4
NEIGHBOURS = 8  # depth maps that each pixel is checked against
ROUNDS = 2  # of voting; later ones weigh a neighbour by its opacity in the last round
TRUNCATION = np.float32(35)  # grey levels at which the matching cost saturates
PENALTIES = np.int16(48), np.float32(510)  # of one plane and of a jump, beside costs of 0 to 510
TOLERANCE = 1.0  # planes within which two depths agree
AGAINST = 1.0  # weight of a free-space violation beside an agreement
SURFACE = 0.1  # see `SplatModel.surface`
# kept by a search at 64x48: matching costs of 5,000 pairs and the depth maps of 350 evaluations;
# older ones are seldom needed again, and allocating more memory takes time
PAIR_BYTES, MAP_BYTES = 1 << 29, 1 << 27


@dataclass(frozen=True)
class SplatSettings:
    """Settings of the reconstructor; none depends on the scene.

    Attributes:
        partners: frames that each frame is matched against, 1 to 4.
        opacity: least opacity of a splat that is kept.
        planes: least and most depth planes, 2 to 128; between, one pixel of disparity each.
    """

    partners: int = 4
    opacity: float = 0.25
    planes: tuple[int, int] = (32, 96)

    def __post_init__(self) -> None:
        object.__setattr__(self, "planes", tuple(self.planes))  # a configuration has a list
        if not 1 <= self.partners <= MAX_PARTNERS:
            raise ValueError(f"partners must be 1 to {MAX_PARTNERS}, got {self.partners}")
        if not 2 <= self.planes[0] <= self.planes[1] <= stereo.MOST_PLANES:
            raise ValueError(
                "planes must be (least, most) with 2 <= least <= most <= "
                f"{stereo.MOST_PLANES}, got {self.planes}"
            )


class Splats(ConfiguredReconstructor[SplatSettings]):
    """The reconstructor bound to one capture; see `SplatSettings`."""

    settings_type = SplatSettings

    def __init__(self, capture: Capture, **settings: Any) -> None:
        super().__init__(capture, **settings)
        self.frames = FrameCache(capture)
        self.frame = Frame.of(capture)
        local = self.frame.localised(capture)
        self.poses = local.world_to_camera
        self.range = planes.depth_range(local)
        self.views, self.look_depth = local.views, planes.look_depth(self.range)
        self.inverse = planes.planes(local, self.range, self.settings.planes)
        self.ks = capture.intrinsics.astype(np.float32)
        self._pairs: dict[tuple[int, int], np.ndarray] = {}
        self._maps: dict[tuple[int, ...], tuple[np.ndarray, np.ndarray]] = {}

    def fit(self, frames: np.ndarray) -> SplatModel:
        """Reconstruct from (K,) int64 distinct frames; ValueError for fewer than two, which have no
        parallax."""
        frames = distinct(frames)
        started, peak = time.perf_counter(), Peak()
        order = self._nearest(frames)
        # pairs of a subset that has more of them than are kept would push each other out
        keep = len(frames) * self.settings.partners <= self._most_pairs

        def mapped(first: int, last: int) -> list[tuple[np.ndarray, np.ndarray]]:
            own, ranked = frames[first:last].tolist(), frames[order[first:last]]
            return [self._depth_map(i, others, keep) for i, others in zip(own, ranked, strict=True)]

        maps = list(chain(*spread(mapped, ranges(len(frames), 1, 16))))
        inverse = np.stack([m[0] for m in maps])
        opacity = np.stack([m[1] for m in maps])
        neighbours = np.ascontiguousarray(order[:, :NEIGHBOURS])
        rotation, translation = _relative(self.poses[frames], neighbours)
        rays = np.stack([self.frames[i].rays for i in frames.tolist()])
        tolerance = TOLERANCE * (self.inverse[frames, 1] - self.inverse[frames, 0])
        kept = Maps(inverse, rays, neighbours, rotation, translation, self.ks[frames], tolerance)
        fused, opacity = agreed(kept, opacity, ROUNDS, AGAINST)
        least = np.float32(self.settings.opacity)
        poses = invert_pose(self.poses[frames]).astype(np.float32)
        images = np.asarray(self.capture.images[frames])
        splats, colors = fusion.place(fused, opacity, rays, poses, images, least)
        return SplatModel(
            frame=self.frame,
            splats=splats,
            colors=colors,
            near=float(self.range[frames, 0].min() / 2),
            far=float(self.range[frames, 1].max() * 2),
            surface=SURFACE,
            pixel=float(1 / self.ks[frames, 0].mean()),
            seconds=time.perf_counter() - started,
            peak_bytes=peak.bytes,
        )

    def _nearest(self, frames: np.ndarray) -> np.ndarray:
        """(K, K - 1) rows of the other frames, best partner first, lowest row among equals."""
        affinity = planes.affinity(
            self.views.centers[frames], self.views.axes[frames], self.look_depth
        )
        return np.argsort(-affinity, axis=1, kind="stable")[:, :-1]

    @property
    def _most_pairs(self) -> int:
        """Matching costs that are kept, of one byte a pixel and plane."""
        width, height = self.capture.size
        return PAIR_BYTES // (width * height * self.inverse.shape[1])

    def _depth_map(
        self, frame: int, ranked: np.ndarray, keep: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        partners = sorted(ranked[: self.settings.partners].tolist())
        key = (frame, *partners)
        depth_map = self._maps.get(key)
        if depth_map is None:
            costs = [self._pair(frame, j, keep) for j in partners]
            padded = (costs * MAX_PARTNERS)[:MAX_PARTNERS]
            cost = stereo.merge_costs(padded, len(costs))
            total = stereo.aggregate(cost, self.frames[frame].grey, *PENALTIES)
            depth_map = stereo.winner(total, cost, self.inverse[frame])
            remember(self._maps, key, depth_map, MAP_BYTES // (2 * depth_map[0].nbytes))
        return depth_map

    def _pair(self, frame: int, source: int, keep: bool) -> np.ndarray:
        if (known := self._pairs.get((frame, source))) is not None:
            return known
        own_pose, other = self.poses[[frame, source]]
        rotation = other[:, :3] @ own_pose[:, :3].T
        translation = other[:, 3] - rotation @ own_pose[:, 3]
        own = self.frames[frame]
        images = own.image, self.frames[source].enlarged, own.rays
        pose = rotation.astype(np.float32), translation.astype(np.float32), self.ks[source]
        cost = stereo.pair_cost(*images, *pose, self.inverse[frame], TRUNCATION)
        cost = stereo.box_filter(cost)
        if keep:
            remember(self._pairs, (frame, source), cost, self._most_pairs)
        return cost


@dataclass(frozen=True)
class SplatModel(Fitted):
    """A reconstruction, in coordinates of its frame."""

    splats: np.ndarray  # (5, n) float32: rows of x, y, z, opacity, depth in the source camera
    colors: np.ndarray  # (n, 3) float32, 0..255
    near: float  # depth from which, and `far` to which, the depth pass resolves surfaces
    far: float
    surface: float  # relative depth behind the visible surface that still belongs to it
    pixel: float  # size of a source pixel at unit depth

    @property
    def primitives(self) -> int:
        """Number of splats."""
        return self.splats.shape[1]

    @property
    def bytes(self) -> int:
        """Memory of the splats."""
        return self.splats.nbytes + self.colors.nbytes

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) float64 centres of the splats, world units."""
        return self.splats[:3].T * self.frame.unit + self.frame.origin

    def painted(self, views: Views, level: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return (T, h, w) float32 renderings of splats painted with levels in [0, 1] that `level`
        makes of their (n,) depths in a view, in the frame's units."""
        shown = []
        for t, pose in enumerate(self.frame.local_poses(views.world_to_camera)):
            share = level(pose[2, :3] @ self.splats[:3] + pose[2, 3])
            paint = np.repeat(255 * share[:, None].astype(np.float32), 3, axis=1)
            alone = replace(self, colors=paint).render(views.subset(slice(t, t + 1)))
            shown.append(alone[0, :, :, 0])
        return np.stack(shown)

    def render(self, views: Views) -> np.ndarray:
        """Return (T, h, w, 3) float32 images in [0, 1] at the given poses."""
        poses = self.frame.local_poses(views.world_to_camera).astype(np.float32)
        ks, surface = views.intrinsics.astype(np.float32), np.float32(self.surface)
        ends = np.float32(self.near), np.float32(self.far)

        def rendered(first: int, last: int) -> np.ndarray:
            given = poses[first:last], ks[first:last], views.size, surface, ends
            return render.render_views(self.splats, self.colors, *given)

        parts = spread(rendered, ranges(len(poses), 1))
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def export_ply(self, path) -> None:
        """Write the splats as a standard 3D Gaussian splatting `.ply`."""
        opacity, depth = self.splats[3:]
        scale = depth * (self.frame.unit * self.pixel / 2)
        ply.write_round(path, self.positions, self.colors / 255, opacity, scale)


def _relative(poses: np.ndarray, neighbours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Camera-to-neighbour rotations (K, M, 3, 3) and translations (K, M, 3), float32."""
    rotation = poses[neighbours][..., :3] @ poses[:, None, :, :3].transpose(0, 1, 3, 2)
    moved = rotation @ poses[:, None, :, 3:]
    translation = poses[neighbours][..., 3] - moved[..., 0]
    return rotation.astype(np.float32), translation.astype(np.float32)
