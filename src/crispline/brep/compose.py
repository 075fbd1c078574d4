"""From a model to a checked solid."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from crispline import occt
from crispline.brep.build import Built, build_shape
from crispline.brep.check import UNMESHED, BadFace, Check, check_shape
from crispline.brep.cusps import with_cusps_opened
from crispline.brep.heal import heal
from crispline.cadfile.step import faces_lost_in_step
from crispline.model import Model
from crispline.occt.measure import Tessellation
from crispline.surface import Similarity
from crispline.surface.base import Array

_HEALINGS = ((0.1, False), (1.0, False), (1.0, True))
"""Repairs to try in turn: largest tolerance in spacings, and whether the parameter
curves of faulty faces are made anew. The gentlest comes first."""


_CROSSED = "BRepCheck_SelfIntersectingWire"
"""Reason of a face whose borders cross, or cannot be told apart at a cusp."""
LOOSE = 0.3
"""With borders of larger tolerance, in spacings, a shape may be another one in a file."""
SPOILT = "it does not survive being written to a STEP file"
"""Reason of a face that is valid in memory only."""


@dataclass(frozen=True)
class Solid:
    """A shape and the evidence for it.

    Attributes
    ----------
    shape : ``TopoDS_Shape`` in the unit of the model.
    check : what was found in it; its ``bad_faces`` are indices into ``Model.faces``,
        -1 for a face that healing has made.
    face_order : model face index of every face of the shape, in exploration order.
    attempt : how the shape came about: ``'as built'``, ``'cusps opened'`` or the repair that
        was kept.
    representation : ``'trimmed'`` faces, ``'mixed'`` with bicubic patches where a region could
        not be trimmed, or ``'patches'`` only.
    mesh : triangles about a spacing wide with vertices on the shape, where it came with some.
    """

    shape: Any
    check: Check
    face_order: tuple[int, ...]
    attempt: str
    representation: Literal["trimmed", "mixed", "patches"] = "trimmed"
    mesh: Tessellation | None = None


def make_solid(
    model: Model, raw_points: Array | None, spacing: float, time_limit: float = 60.0
) -> Solid:
    """Build, check, and if need be repair the solid that a model describes.

    1. The shape is built as the model says. If it is good it is returned untouched, as
       it is when only its distance to the cloud is at fault: no repair can cure that.
    2. Where borders cross beside a vertex, it is built again with edges that part there.
    3. Otherwise the repairs of ``_HEALINGS`` are tried, and the first good shape is
       returned; without one, the shape with the fewest faults, and a check that says so. A
       repair that cannot say which face of the model fails is no better than none.
    4. A good shape with large gaps is written and read back where it stands: a file may spoil
       its faces in the model's frame and not in another.

    Parameters
    ----------
    model : in any unit; see :attr:`Model.is_closed`. An open one gives a shell.
    raw_points : the cloud without outliers in the model's unit, shape ``(n, 3)``, or None.
    spacing : mean distance between neighbouring points, in the model's unit.
    time_limit : seconds for all repairs together.

    Returns
    -------
    Solid
        ``solid.check.is_good`` tells whether it is one.

    Raises
    ------
    ReconstructionError
        If the geometry of an edge or face is no geometry at all.
    """
    to_unit = _to_unit_spacing(model, spacing)
    scaled = model.transformed(to_unit)
    built = build_shape(scaled)
    points = None if raw_points is None else to_unit.points(raw_points)
    first = best = _judge(built, built.shape, points, "as built", not model.is_closed)
    crossed = {fault.index for fault in best.check.bad_faces if fault.reason == _CROSSED} - {-1}
    if crossed:
        opened = build_shape(with_cusps_opened(scaled, sorted(crossed)))
        second = _judge(opened, opened.shape, points, "cusps opened", not model.is_closed)
        if _n_faults(second) < _n_faults(first):
            built, first = opened, second
            best = first
    deadline = time.monotonic() + time_limit
    if _is_repairable(best.check):
        for max_tolerance, drop_pcurves in _HEALINGS:
            healed = heal(built.shape, max_tolerance, deadline - time.monotonic(), drop_pcurves)
            if healed is None:
                continue
            attempt = f"healed to {max_tolerance:g} spacings" + ", new pcurves" * drop_pcurves
            best = min(
                best, _judge(built, healed, points, attempt, not model.is_closed), key=_n_faults
            )
            if best.check.is_good:
                break
        if any(fault.index < 0 for fault in best.check.bad_faces):
            best = first
    back = to_unit.inverse()
    scale = back.scale
    check = replace(
        best.check,
        volume=best.check.volume * scale**3,
        edge_tolerance=best.check.edge_tolerance * scale,
        vertex_tolerance=best.check.vertex_tolerance * scale,
    )
    shape = occt.transform(best.shape, back)
    if check.is_good and max(check.edge_tolerance, check.vertex_tolerance) > LOOSE * spacing:
        lost = [BadFace(best.face_order[index], SPOILT) for index in faces_lost_in_step(shape)]
        check = replace(check, bad_faces=tuple(lost))
    return replace(best, shape=shape, check=check)


def _to_unit_spacing(model: Model, spacing: float) -> Similarity:
    """To a frame of spacing 1 about the model's middle, where OCCT's tolerances make sense."""
    places = [model.vertices, *(edge.curve.samples(3) for edge in model.edges)]
    places += [face.surface.project(np.zeros((1, 3)))[0] for face in model.faces if not face.loops]
    corners = np.concatenate(places)
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    return Similarity(1.0 / spacing, np.eye(3), -middle / spacing)


def _judge(
    built: Built, shape: Any, points: Array | None, attempt: str, may_be_open: bool
) -> Solid:
    check = check_shape(shape, points, 1.0, may_be_open)
    has_same_faces = check.n_faces == len(built.face_order)
    order = built.face_order if has_same_faces else (-1,) * check.n_faces
    bad = [BadFace(order[fault.index], fault.reason) for fault in check.bad_faces]
    bad += [BadFace(index, reason) for index, reason in built.failures]
    named = tuple(sorted(bad, key=lambda fault: fault.index))
    return Solid(shape, replace(check, bad_faces=named), order, attempt)


def _is_repairable(check: Check) -> bool:
    """Whether OCCT itself finds a fault, or cannot fill a face."""
    return not check.is_valid or any(fault.reason == UNMESHED for fault in check.bad_faces)


def _n_faults(solid: Solid) -> tuple[bool, bool, int]:
    check = solid.check
    return not check.is_valid, not check.is_closed, len(check.bad_faces) + len(check.problems)
