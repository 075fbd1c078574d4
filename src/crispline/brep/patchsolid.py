"""The whole model as bicubic patches, checked: what is left where no segmentation suits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer

from crispline import occt
from crispline.brep.check import STRAY, BadFace, Check, shared_edges_only
from crispline.brep.compose import Solid
from crispline.brep.patchwork import Patchwork, build_patchwork
from crispline.errors import InputError, ReconstructionError
from crispline.gauge.deviation import measure_deviation
from crispline.occt.measure import Tessellation, volume
from crispline.spline.bezier import corner_points
from crispline.spline.creased import CreasedNet
from crispline.spline.relax import relaxed
from crispline.spline.separate import separated
from crispline.spline.through import passing_through
from crispline.surface.base import Array

_RELAXED_RINGS = 3  # beside creases, whose vertices were moved
_VOLUME_ERROR = 1e-6


def patch_solid(net: CreasedNet, raw_points: Array | None, spacing: float) -> Solid:
    """The limit surface through the vertices of a net as a checked solid or shell.

    Parameters
    ----------
    net : counter-clockwise quads seen from outside, in any unit; an open one gives a shell.
    raw_points : the cloud without outliers in the unit of the net, shape ``(n, 3)``, or None.
    spacing : mean distance between neighbouring points, in that unit.

    Returns
    -------
    Solid
        None of its faces is a face of a model: ``face_order`` is -1 for all.

    Raises
    ------
    ReconstructionError
        If the net is no oriented surface.
    """
    try:
        whole = separated(net)
        smooth = passing_through(relaxed(whole, np.unique(whole.creases), _RELAXED_RINGS))
        patchwork = build_patchwork(smooth)
    except InputError as error:
        raise ReconstructionError(f"no surface of patches: {error}") from error
    mesh = _mesh(smooth, patchwork)
    check = _check(patchwork.shape, mesh, patchwork.quilt.is_closed, raw_points, spacing)
    order = (-1,) * check.n_faces
    return Solid(patchwork.shape, check, order, "patches", "patches", mesh)


def _mesh(net: CreasedNet, patchwork: Patchwork) -> Tessellation:
    """Two triangles a quad, with vertices on the limit surface."""
    face = patchwork.quilt.face_of_quad
    quads = np.where(patchwork.is_turned[face, None], net.quads[:, ::-1], net.quads)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    position = np.nan_to_num(corner_points(net).position)
    return Tessellation(position, triangles, np.tile(patchwork.place[face], 2))


def _check(
    shape: Any, mesh: Tessellation, is_closed: bool, raw_points: Array | None, spacing: float
) -> Check:
    """As :func:`crispline.brep.check.check_shape`, on triangles that need no OCCT mesher."""
    n_faces = len(occt.subshapes(shape, occt.FACE))
    n_solids = len(occt.subshapes(shape, occt.SOLID))
    may_be_open = not is_closed
    is_closed = is_closed and n_solids > 0 and shared_edges_only(shape)
    enclosed = volume(shape, _VOLUME_ERROR) if is_closed else 0.0
    check = Check(
        bool(BRepCheck_Analyzer(shape).IsValid()),
        is_closed,
        n_solids,
        n_faces,
        len(occt.subshapes(shape, occt.EDGE)),
        len(occt.subshapes(shape, occt.VERTEX)),
        enclosed,
        occt.largest_tolerance(shape, occt.EDGE),
        occt.largest_tolerance(shape, occt.VERTEX),
        np.zeros(n_faces),
        0,
        (),
        (f"the enclosed volume is {enclosed:.3g}",) if is_closed and enclosed <= 0.0 else (),
        may_be_open,
    )
    if raw_points is None:
        return check
    deviation = measure_deviation(mesh, n_faces, raw_points, spacing, STRAY)
    bad = [
        BadFace(-1, f"a patch is {distance:.1f} spacings from the cloud")
        for distance in deviation.face_distances[deviation.face_distances > STRAY]
    ]
    n_uncovered = int(deviation.n_uncovered.sum())
    if n_uncovered:
        bad.append(BadFace(-1, f"{n_uncovered} raw points are uncovered"))
    return replace(
        check,
        face_distances=deviation.face_distances,
        n_uncovered=n_uncovered,
        bad_faces=tuple(bad),
    )
