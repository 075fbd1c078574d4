"""Small pieces of a scan that lie apart from the net."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from crispline.surface.base import Array

_APART = 2.5  # spacings from the net's vertices
_LINK = 3.0  # points of one piece are no farther apart


def stray_pieces(
    points: Array, vertices: Array, min_piece: int, threads: int = -1
) -> NDArray[np.int64]:
    """The small piece of the scan that each point is on, shape ``(n,)``; -1 on the net.

    What is too small to become a surface leaves points that no model covers: leaves and
    wires beside a roof, the table under a part. A piece of ``min_piece`` points or more is
    none of these, and is -1 too: a model without it has a fault.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    vertices : of the net, shape ``(m, 3)``.
    min_piece : pieces with fewer points are small.
    threads : threads for neighbour queries; the result does not depend on it.
    """
    piece = np.full(len(points), -1)
    distance, _ = cKDTree(vertices).query(points, distance_upper_bound=_APART, workers=threads)
    apart = np.flatnonzero(np.isinf(distance))
    pairs = cKDTree(points[apart]).query_pairs(_LINK, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(apart), len(apart)))
    name = np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)
    is_small = np.bincount(name)[name] < min_piece
    piece[apart[is_small]] = np.unique(name[is_small], return_inverse=True)[1]
    return piece


def strays_sentence(points: Array, piece: NDArray[np.int64]) -> str:
    """How many points the model leaves out, and where most of them lie; empty if none."""
    n_pieces = int(piece.max(initial=-1)) + 1
    if n_pieces == 0:
        return ""
    largest = points[piece == np.bincount(piece[piece >= 0]).argmax()]
    place = "({:.4g}, {:.4g}, {:.4g})".format(*np.median(largest, axis=0))
    return (
        f"{int((piece >= 0).sum())} points on {n_pieces} small pieces apart from the surface are "
        f"not in the model; the largest piece has {len(largest)} points, near {place}"
    )
