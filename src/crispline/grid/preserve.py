"""Step five on a grid or a B-spline surface: the surface anew at and around the sharp patches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import ndimage
from scipy.interpolate import make_interp_spline

from crispline.grid.centres import grid_centres, surface_centres
from crispline.grid.cut import cut_net
from crispline.grid.lattice import Lattice, Surface, as_lattice
from crispline.grid.locate import Located
from crispline.grid.tensor import creased_along
from crispline.options import SharpenOptions
from crispline.spline.creased import PolygonNet
from crispline.spline.tensor import TensorSpline, spline_over_grid
from crispline.surface.base import Array


def preserve(
    surface: Surface | Lattice, located: Located, options: SharpenOptions | None = None
) -> TensorSpline | PolygonNet:
    """The surface with the located edges and corners in it.

    Parameters
    ----------
    surface : what they were located on.
    located : from :func:`crispline.grid.locate`.
    options : ``repeat`` is used.

    Returns
    -------
    One tensor product with a knot of that multiplicity for each edge, if all edges
    run along rows or columns through the whole surface; without edges the plain
    surface. Else, and for a grid with invalid pixels, a control net with creases:
    see :func:`crispline.grid.cut.cut_net`.
    """
    options = options or SharpenOptions()
    lattice = as_lattice(surface)
    is_whole = bool(lattice.has_patch.all())
    has_edges = bool(len(located.crossings.axis)) or located.lines is not None
    if is_whole and (located.lines is not None or not has_edges):
        given = lattice.given
        plain = given if isinstance(given, TensorSpline) else spline_over_grid(given)
        return creased_along(plain, located.lines or (), located.corners, lattice, options.repeat)
    net = lattice.points if lattice.is_measured else _control_net(lattice, located)
    cut = cut_net(net, lattice.has_patch, located.crossings, located.corners, options.repeat == 3)
    return replace(cut, vertices=lattice.to_input(cut.vertices))


def resampling_error(surface: Surface | Lattice, located: Located) -> float:
    """Largest distance between a given surface and the uniform net it is brought to.

    At the middles of the patches that are farther than four patches from an edge, in
    the surface's unit; 0 where the surface stays what it is.
    """
    lattice = as_lattice(surface)
    if not isinstance(lattice.given, TensorSpline) or located.lines is not None:
        return 0.0
    if not len(located.crossings.axis):
        return 0.0
    given = surface_centres(lattice.given, lattice.u, lattice.v).point
    net = lattice.to_input(_control_net(lattice, located))
    away = np.linalg.norm(grid_centres(net).point - given, axis=2)
    near = ndimage.binary_dilation(located.is_sharp, np.ones((3, 3), dtype=bool), iterations=4)
    return float(away[~near].max(initial=0.0))


def _control_net(lattice: Lattice, located: Located) -> Array:
    """Control points of a uniform bicubic net for a given surface, its sides continued.

    The net interpolates the surface at its knots, over its own uniform parameters,
    with the border condition of :func:`spline_over_grid`; beside the edges the points
    are those of the sides.
    """
    net = _interpolating(_interpolating(lattice.points).swapaxes(0, 1)).swapaxes(0, 1)
    return np.where(np.isfinite(located.continued), located.continued, net)


def _interpolating(points: Array) -> Array:
    """Control points along axis 0 whose uniform cubic passes through the points at its knots.

    The second derivative vanishes at the ends, as linear extrapolation makes it.
    """
    index = np.arange(len(points))
    spline = make_interp_spline(index, points, k=3, bc_type="natural")
    # S = (a + 4 b + c)/6 and S'' = a - 2 b + c at the knot of b.
    return np.asarray(points - spline(index, 2) / 6.0)
