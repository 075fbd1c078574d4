"""Nets end where the points do, and where they were torn from one sheet to another."""

import numpy as np
from scipy.spatial import cKDTree

from crispline.net.trim import trimmed


def sheet(nets, n=20):
    """A net of n by n quads and the points under it."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return vertices, nets.grid(n + 1, n + 1)


def cut(vertices, quads, points):
    return trimmed(vertices, quads, cKDTree(points), np.ones(len(points)), 6.0, 10, 1)


def test_a_net_over_its_points_stays_whole(nets):
    vertices, quads = sheet(nets)
    assert len(cut(vertices, quads, vertices).quads) == len(quads)


def test_quads_torn_between_two_sheets_are_cut(nets):
    vertices, quads = sheet(nets)
    is_high = vertices[:, 0] > 10.0
    vertices[is_high, 2] = 5.0
    is_torn = is_high[quads].any(axis=1) & ~is_high[quads].all(axis=1)
    # Points all over the step: it is covered, but no quad spans it at the spacing of the net.
    found = cut(vertices, quads, vertices)
    sides = found.vertices[found.quads] - found.vertices[np.roll(found.quads, -1, axis=1)]
    assert np.linalg.norm(sides, axis=2).max() < 5.0
    assert len(found.quads) <= len(quads) - is_torn.sum()
