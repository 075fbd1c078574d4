"""Step five on a tensor-product surface: an edge along a parameter line becomes a triple knot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, hstack, vstack
from scipy.sparse.linalg import splu

from crispline.grid.corners import Corners
from crispline.grid.isolines import IsoLine
from crispline.grid.lattice import Lattice
from crispline.grid.localfit import Sides
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array

CUBIC = 3


def creased_along(
    surface: TensorSpline,
    lines: Sequence[IsoLine],
    corners: Corners,
    lattice: Lattice,
    multiplicity: int,
) -> TensorSpline:
    """The surface with creases along parameter lines.

    A knot of the given multiplicity is inserted at each line, which changes
    nothing. With multiplicity 3 the surface then has a control column whose
    curve the surface passes through; it is solved to pass through the located
    points. The columns next to it, the only others that mix points of both
    sides, are moved onto their side. All other control points stay, so the
    surface stays beyond two spans of the old surface from each line.

    Parameters
    ----------
    surface : bicubic, over the parameters of the lattice, in the input's unit.
    lines : the edges, spacings.
    corners : where lines cross, spacings.
    multiplicity : 1 to 3. Below 3 the inserted columns themselves are drawn to the
        located points, and the surface stays smooth.
    """
    for line in lines:
        levels = (lattice.u, lattice.v)[line.axis]
        level = float(np.interp(line.at, np.arange(len(levels)), levels))
        surface = (surface if line.axis == 0 else surface.transposed()).with_knot_u(
            level, multiplicity
        )
        surface = surface if line.axis == 0 else surface.transposed()
    for line in lines:
        levels = (lattice.u, lattice.v)[line.axis]
        level = float(np.interp(line.at, np.arange(len(levels)), levels))
        turned = surface if line.axis == 0 else surface.transposed()
        course = _course(line, lines, corners, lattice)
        turned = _creased(turned, line, course, level, lattice, multiplicity)
        surface = turned if line.axis == 0 else turned.transposed()
    return surface


def _course(
    line: IsoLine, lines: Sequence[IsoLine], corners: Corners, lattice: Lattice
) -> tuple[Array, Array]:
    """Parameters and points of a line, with the corners that other lines make on it."""
    along, points = line.along, line.points
    levels = (lattice.v, lattice.u)[line.axis]
    for other in lines:
        place = np.empty(2)
        place[line.axis], place[other.axis] = line.at, other.at
        away = np.abs(corners.cells + 0.5 - place).max(axis=1, initial=0.0)
        level = float(np.interp(other.at, np.arange(len(levels)), levels))
        is_known = (np.abs(along - level) < 1e-9 * np.ptp(along)).any()
        if other.axis == line.axis or is_known or not (away <= 1.0).any():
            continue
        index = int(np.searchsorted(along, level))
        along = np.insert(along, index, level)
        points = np.insert(points, index, corners.points[away.argmin()], axis=0)
    return along, points


def _creased(
    surface: TensorSpline,
    line: IsoLine,
    course: tuple[Array, Array],
    level: float,
    lattice: Lattice,
    multiplicity: int,
) -> TensorSpline:
    """One line of constant ``u`` whose knot is there already, through the points of a course."""
    points = surface.control_points.copy()
    first = int(np.searchsorted(surface.knots_u, level - 1e-9 * _width(surface.knots_u)))
    # The control row whose three knots are all at the level, for multiplicity 3.
    row = first - 1 if multiplicity == CUBIC else first - 1 - (CUBIC - multiplicity) // 2
    weights = None if surface.weights is None else surface.weights[row]
    along, located = course[0], lattice.to_input(course[1])
    crease = interpolating_controls(surface.knots_v, weights, along, located)
    if multiplicity < CUBIC:
        for k in range(multiplicity):
            points[row + k - (multiplicity - 1)] = crease
        return replace(surface, control_points=points)
    points[row] = crease
    # Where each control point of a row belongs along the line: the mean of its knots.
    greville = (surface.knots_v[1:-3] + surface.knots_v[2:-2] + surface.knots_v[3:-1]) / 3.0
    nearest = np.abs(greville[:, None] - line.along[None, :]).argmin(axis=1)
    uv = np.empty((len(greville), 2))
    uv[:, line.axis], uv[:, 1 - line.axis] = level, greville
    for beside, side in ((row - 1, line.before), (row + 1, line.after)):
        points[beside] = _onto(side[nearest], points[beside], uv, lattice)
    return replace(surface, control_points=points)


def _onto(sides: Sides, points: Array, uv: Array, lattice: Lattice) -> Array:
    """Feet of control points on their side."""
    local = (points - lattice.origin) / lattice.spacing
    return lattice.to_input(sides.foot(local, uv)[0])


def interpolating_controls(
    knots: Array, weights: Array | None, parameters: Array, points: Array
) -> Array:
    """Control points of the cubic curve through points at parameters that wiggles least.

    Parameters
    ----------
    knots : shape ``(n + 4,)``.
    weights : of the control points, shape ``(n,)``; None for a polynomial curve.
    parameters : increasing, shape ``(k,)``, ``k <= n``.
    points : shape ``(k, 3)``.

    Returns
    -------
    Shape ``(n, 3)``. Among all curves through the points the one with the least
    sum of squared third divided differences of the control points; it goes on
    like a parabola at the ends, where a natural spline would straighten. Across a
    knot of multiplicity 3 the curve may have a corner.
    """
    basis = csr_array(BSpline.design_matrix(parameters, knots, CUBIC, extrapolate=True))
    if weights is not None:
        basis = csr_array(basis.multiply(weights))
        basis = csr_array(basis.multiply((1.0 / basis.sum(axis=1))[:, None]))
    third = _third_differences(knots)
    n = third.shape[1]
    # Mean and size of the points are taken out, so that rounding is relative to the shape.
    middle = points.mean(axis=0)
    empty = csr_array((len(parameters), len(parameters)))
    system = vstack(
        [hstack([csr_array(third.T @ third), basis.T]), hstack([basis, empty])], format="csc"
    )
    right = np.concatenate([np.zeros((n, 3)), points - middle])
    return np.asarray(splu(system).solve(right)[:n] + middle)


def _third_differences(knots: Array) -> csr_array:
    """Third divided differences of control points over the means of their knots, ``(r, n)``."""
    greville = (knots[1:-3] + knots[2:-2] + knots[3:-1]) / 3.0
    n = len(greville)
    first = np.arange(n - 3)
    # Not across a control point that the curve passes through.
    is_hinge = knots[1:-3] == knots[3:-1]
    first = first[~(is_hinge[first + 1] | is_hinge[first + 2])]
    columns = first[:, None] + np.arange(4)
    place = greville[columns] / np.mean(np.diff(greville))
    gap = place[:, :, None] - place[:, None, :] + np.eye(4)
    rows = np.repeat(np.arange(len(first)), 4)
    return csr_array(
        (np.ravel(1.0 / gap.prod(axis=2)), (rows, columns.ravel())), shape=(len(first), n)
    )


def _width(knots: Array) -> float:
    return float(knots[-1] - knots[0])
