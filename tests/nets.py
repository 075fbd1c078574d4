"""Quad nets of simple shapes, consistently oriented, counter-clockwise from outside."""

import numpy as np


def grid(n_u, n_v, is_closed=False):
    """Quads of ``n_u x n_v`` vertices; vertex ``(i, j)`` is ``i * n_v + j``; u along i.

    Open, or closed in both directions to a torus.
    """
    end_u, end_v = (n_u, n_v) if is_closed else (n_u - 1, n_v - 1)
    i, j = (index.ravel() for index in np.mgrid[:end_u, :end_v])
    next_i, next_j = (i + 1) % n_u, (j + 1) % n_v
    return np.stack([i * n_v + j, next_i * n_v + j, next_i * n_v + next_j, i * n_v + next_j], 1)


def plane(n_u, n_v, step=1.0):
    i, j = np.mgrid[:n_u, :n_v]
    vertices = np.stack([step * i, step * j, np.zeros(i.shape)], axis=2).reshape(-1, 3)
    return vertices, grid(n_u, n_v)


def torus(n_u, n_v, major=10.0, minor=4.0):
    """u runs round the axis, v round the tube."""
    i, j = np.mgrid[:n_u, :n_v]
    u, v = 2.0 * np.pi * i / n_u, 2.0 * np.pi * j / n_v
    rho = major + minor * np.cos(v)
    vertices = np.stack([rho * np.cos(u), rho * np.sin(u), minor * np.sin(v)], axis=2)
    return vertices.reshape(-1, 3), grid(n_u, n_v, is_closed=True)


def box(n, half=1.0):
    """Surface of a cube with ``n x n`` quads a side, and the side of every quad."""
    corners, sides = [], []
    for axis in range(3):
        for sign in (-1, 1):
            i, j = (index.ravel() for index in np.mgrid[:n, :n])
            loop = [(0, 0), (1, 0), (1, 1), (0, 1)][:: 1 if sign > 0 else -1]
            quad = np.zeros((n * n, 4, 3), dtype=np.int64)
            quad[:, :, axis] = n if sign > 0 else 0
            for k, (du, dv) in enumerate(loop):
                quad[:, k, (axis + 1) % 3] = i + du
                quad[:, k, (axis + 2) % 3] = j + dv
            corners.append(quad)
            sides.append(np.full(n * n, 2 * axis + (sign > 0)))
    places, index = np.unique(np.concatenate(corners).reshape(-1, 3), axis=0, return_inverse=True)
    vertices = half * (2.0 * places / n - 1.0)
    return vertices, index.reshape(-1, 4), np.concatenate(sides)


def borders(quads, label):
    """Sides between quads of different labels, shape ``(e, 2)``."""
    sides = {}
    for quad, name in zip(quads.tolist(), label, strict=True):
        for pair in zip(quad, quad[1:] + quad[:1], strict=True):
            sides.setdefault(tuple(sorted(pair)), set()).add(name)
    return np.array([pair for pair, labels in sides.items() if len(labels) > 1])


def sphere(n, radius=1.0):
    """The box of ``n x n`` quads a side, blown up; quads of nearly equal size."""
    vertices, quads, _ = box(n)
    vertices = np.tan(np.pi / 4.0 * vertices)
    return radius * vertices / np.linalg.norm(vertices, axis=1, keepdims=True), quads
