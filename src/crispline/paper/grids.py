"""The sharpening of grids, `--rule paper` and `--rule robust`, on the experiment's windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.errors import CrisplineError
from crispline.grid.sharpen import sharpen
from crispline.options import SharpenOptions
from crispline.paper.measure import Deviation, Hits, deviation, hits
from crispline.paper.patches import Patches, spline_patches
from crispline.paper.rows import Rule, Trial
from crispline.paper.windows import FEATURES, Feature, Window, windows
from crispline.spline.bezier import bezier_patches
from crispline.spline.creased import CreasedNet, PolygonNet, subdivided
from crispline.spline.tensor import TensorSpline, spline_over_grid


@dataclass(frozen=True)
class GridRun:
    """All windows of one kind of feature at one position, noise level and seed."""

    feature: Feature
    phase: float
    noise: float
    seed: int
    rules: tuple[Rule, ...]

    @property
    def title(self) -> str:
        """What progress shows."""
        return f"grids at {100.0 * self.noise:g} % noise"

    @property
    def cost(self) -> float:
        """How long it takes, in runs on grids."""
        return 1.0

    def trials(self, threads: int) -> list[Trial]:
        """Measure every rule on the same noisy windows."""
        clean = windows(self.feature, self.phase)
        streams = np.random.default_rng([self.seed, FEATURES.index(self.feature)]).spawn(len(clean))
        noisy = [w.noisy(self.noise, s) for w, s in zip(clean, streams, strict=True)]
        before = [deviation(spline_patches(spline_over_grid(w.points)), w) for w in noisy]
        return [self._trial(rule, clean, noisy, before) for rule in self.rules]

    def _trial(
        self,
        rule: Rule,
        clean: Sequence[Window],
        noisy: Sequence[Window],
        before: Sequence[Deviation],
    ) -> Trial:
        after, found, n_failed = [], [], 0
        for true, given, plain in zip(clean, noisy, before, strict=True):
            try:
                surface, is_sharp = sharpened(given.points, rule)
            except CrisplineError:  # the user is left with the plain surface
                after.append(plain)
                found.append(hits(np.zeros_like(true.is_patch), true, self.noise))
                n_failed += 1
                continue
            after.append(deviation(surface, given))
            found.append(hits(is_sharp, true, self.noise))
        return Trial(
            method=rule,
            sampling=f"grid {position(self.phase)}",
            noise=self.noise,
            feature=self.feature,
            seed=self.seed,
            before=_mean(before),
            after=_mean(after),
            found=_total(found),
            n_windows=len(clean),
            n_failed=n_failed,
        )


def position(phase: float) -> str:
    """A phase as rows show it, with two decimals or as many as it needs.

    >>> position(0.5), position(0.125)
    ('0.50', '0.125')
    """
    return max(f"{phase:.2f}", f"{phase:.6f}".rstrip("0"), key=len)


def sharpened(points: NDArray[np.float64], rule: Rule) -> tuple[Patches, NDArray[np.bool_]]:
    """The sharpened surface over a grid, and which of its cells were found sharp."""
    result = sharpen(points, SharpenOptions(rule=rule))
    return surface_patches(result.surface), result.is_sharp


def surface_patches(surface: TensorSpline | CreasedNet | PolygonNet) -> Patches:
    """Bezier patches of what sharpening returns.

    Exact for a tensor product, on edges and at corners; where the cut of a net leaves
    irregular cells see :func:`crispline.spline.bezier.bezier_patches`.
    """
    if isinstance(surface, TensorSpline):
        return spline_patches(surface)
    net = subdivided(surface) if isinstance(surface, PolygonNet) else surface
    return Patches(bezier_patches(net))


def _mean(deviations: Sequence[Deviation]) -> Deviation:
    return Deviation(
        error=float(np.mean([d.error for d in deviations])),
        reverse_mean=float(np.mean([d.reverse_mean for d in deviations])),
        reverse_p99=float(np.mean([d.reverse_p99 for d in deviations])),
    )


def _total(found: Sequence[Hits]) -> Hits:
    return Hits(
        n_sharp=sum(hit.n_sharp for hit in found),
        n_true=sum(hit.n_true for hit in found),
        n_pieces=sum(hit.n_pieces for hit in found),
        n_found=sum(hit.n_found for hit in found),
    )
