"""Nets with every kind of vertex, shared by the tests of the surfaces over them."""

import numpy as np

from crispline.spline.creased import CreasedNet, subdivided

NONE = np.zeros((0, 2), dtype=np.int64)
NO_CORNERS = np.zeros(0, dtype=np.int64)


def open_grid(nets, n_u, n_v, seed, noise=0.3):
    """A ragged regular grid with its four corners tagged."""
    vertices, quads = nets.plane(n_u, n_v)
    vertices = vertices + noise * np.random.default_rng(seed).normal(size=vertices.shape)
    return CreasedNet(vertices, quads, NONE, np.array([0, n_v - 1, (n_u - 1) * n_v, n_u * n_v - 1]))


def sharp_box(nets, n):
    """A cube of half side 1 whose twelve edges are creases."""
    vertices, quads, side = nets.box(n)
    return CreasedNet(vertices, quads, nets.borders(quads, side), NO_CORNERS)


def fan(kind, k, seed=0, noise=0.0, n_steps=2):
    """A dome or a ridge round vertex 0, which is of one kind; sides are about 1 long.

    kind : ``smooth``, ``dart``, ``crease`` or ``corner``; vertex 0 has ``k`` quads all
    round, or on one side of its crease (two on the other).
    """
    is_ring = kind in ("smooth", "dart")
    if is_ring:
        angle = np.pi * np.arange(2 * k) / k
    else:
        angle = np.concatenate(
            [np.pi * np.arange(2 * k + 1) / (2 * k), np.pi * np.arange(5, 8) / 4]
        )
    n = len(angle)
    radius = np.where(np.arange(n) % 2 == 0, 4.0, 5.2)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(n)], axis=1)
    quads = [[0, 1 + i, 2 + i, 1 + (i + 2) % n] for i in range(0, n, 2)]
    creases = {
        "smooth": NONE,
        "dart": [[0, 1]],
        "crease": [[0, 1], [0, 1 + 2 * k]],
        "corner": [[0, 1], [0, 1 + 2 * k], [0, 3 + 2 * k]],
    }[kind]
    net = CreasedNet(np.vstack([np.zeros(3), rim]), np.array(quads), np.array(creases), NO_CORNERS)
    for _ in range(n_steps):
        net = subdivided(net)
    x, y = net.vertices[:, :2].T
    rng = np.random.default_rng(seed)
    a, b, c = rng.normal(size=3)
    ridge = {"smooth": 0.0, "dart": np.clip(x, 0.0, 1.0)}.get(kind, 1.0)
    z = 0.075 * (a * x**2 + b * x * y + c * y**2) - 0.7 * ridge * np.abs(y)
    vertices = np.stack([x, y, z], axis=1) + noise * rng.normal(size=net.vertices.shape)
    return CreasedNet(vertices, net.quads, net.creases, net.corners)
