"""Field-aligned quads over a triangle mesh (Jakob et al. 2015)."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator

import numpy as np
import pynanoinstantmeshes
from numpy.typing import NDArray

from crispline.errors import ReconstructionError
from crispline.net.mesh import TriangleMesh
from crispline.surface.base import Array


def quads_over(mesh: TriangleMesh, edge_length: float) -> tuple[Array, NDArray[np.int64]]:
    """Vertices and quads of about the given side over a triangle mesh.

    Raises
    ------
    ReconstructionError
        If there are no quads.
    """
    with _quiet_stdout():
        vertices, quads = pynanoinstantmeshes.remesh(
            mesh.vertices.astype(np.float32),
            mesh.triangles.astype(np.uint32),
            vertex_count=-1,
            scale=2.0 * edge_length,  # the mesher halves it when it makes pure quads
            creaseAngle=-1.0,  # 0 would make every edge a crease
            deterministic=True,
            smooth_iter=2,
            extrinsic=True,
            align_to_boundaries=False,  # borders are ragged, and would turn the quads
        )
    if len(quads) == 0:
        raise ReconstructionError(
            "quad meshing of the cloud gave no quads; the part may be smaller than "
            "a few point spacings: scan it more densely"
        )
    vertices = np.asarray(vertices, dtype=np.float64)
    proper = without_slits(np.asarray(quads, dtype=np.int64))
    used, renumbered = np.unique(proper, return_inverse=True)
    return vertices[used], renumbered.reshape(proper.shape)


def without_slits(quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """Quads of four different vertices, shape ``(k, 4)``.

    The mesher leaves a quad ``a b a c`` now and then. It encloses nothing: without it its
    neighbours are each other's along ``a b`` and ``a c``.
    """
    ranked = np.sort(quads, axis=1)
    return quads[(ranked[:, 1:] > ranked[:, :-1]).all(axis=1)]


@contextlib.contextmanager
def _quiet_stdout() -> Iterator[None]:
    """Silence a C++ library that writes progress to the process's standard output."""
    sys.stdout.flush()
    try:
        saved = os.dup(1)
    except OSError:  # no standard output at all, as under some services
        yield
        return
    with open(os.devnull, "w") as sink:
        os.dup2(sink.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(saved, 1)
            os.close(saved)
