"""From the cloud to the located edges: what is tried where corners are lost."""

from dataclasses import replace

import numpy as np

from crispline import features
from crispline.features import located_features
from crispline.options import Options
from crispline.region.claim import Claim
from crispline.region.segment import segment
from crispline.stopwatch import Stopwatch


def chamfered_bar():
    """A bar with a chamfer two spacings wide along one edge; about a point per unit of area."""
    profile = np.array([[0.0, 0.0], [24.0, 0.0], [24.0, 14.6], [22.6, 16.0], [0.0, 16.0]])
    rng = np.random.default_rng(3)
    length, parts = 30.0, []
    for start, end in zip(profile, np.roll(profile, -1, axis=0), strict=True):
        n = int(np.linalg.norm(end - start) * length)
        at = start + rng.random((n, 1)) * (end - start)
        parts.append(np.column_stack([at, rng.random(n) * length]))
    for z in (0.0, length):
        at = rng.random((384, 2)) * [24.0, 16.0]
        parts.append(
            np.column_stack([at[at.sum(axis=1) < 38.6], np.full(sum(at.sum(1) < 38.6), z)])
        )
    points = np.concatenate(parts)
    return points + rng.normal(0.0, 0.1, points.shape)


def test_a_narrow_face_that_ends_too_early_goes_on(monkeypatch):
    def cut_short(evidence, net_vertices, quads, is_sharp, options, fit_options):
        found = segment(evidence, net_vertices, quads, is_sharp, options, fit_options)
        assert len(found.fits) == 7
        narrow = int(np.argmin(np.bincount(found.label)))
        own = np.flatnonzero(found.label == narrow)
        along = (
            evidence.graph.points[own]
            @ np.linalg.svd(evidence.graph.points[own] - evidence.graph.points[own].mean(axis=0))[
                2
            ][0]
        )
        lost = np.zeros(len(found.label), dtype=bool)
        lost[own[along > np.quantile(along, 0.6)]] = True
        beside = np.unique(found.label[evidence.graph.rings(lost, 1) & ~lost])
        sides = sorted(beside.tolist(), key=lambda r: -np.sum(found.label == r))[:2]
        claims = [Claim(found.fits[r], evidence, options).patch_costs(lost)[lost] for r in sides]
        label = found.label.copy()
        label[lost] = np.array(sides)[np.argmin(claims, axis=0)]
        return replace(found, label=label)

    whole = located_features(chamfered_bar(), Options(), Stopwatch()).ladder
    assert whole.model.vertex_gaps.max() < 0.1
    monkeypatch.setattr(features, "segment", cut_short)
    mended = located_features(chamfered_bar(), Options(), Stopwatch()).ladder
    assert len(mended.model.vertices) == len(whole.model.vertices) == 10
    assert mended.model.vertex_gaps.max() < 0.1
    monkeypatch.setattr(features, "moved_near", lambda *_: None)
    assert (
        located_features(chamfered_bar(), Options(), Stopwatch()).ladder.model.vertex_gaps.max()
        > 0.3
    )
