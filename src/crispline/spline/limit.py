"""Where the vertices of a creased net end up under subdivision, and how the surface lies there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crispline.spline.bezier import corner_points
from crispline.spline.creased import CreasedNet
from crispline.spline.sectors import Kind, require_single_fans
from crispline.surface.base import Array, unit


@dataclass(frozen=True)
class LimitPoints:
    """Limit surface at the vertices of a net.

    A vertex on a crease has a normal on each side of it, so normals and tangents
    belong to the corners of the quads.

    Attributes
    ----------
    position : shape ``(n, 3)``; NaN for a vertex without quads.
    tangents : along the side that leaves each corner of a quad and along the one
        that arrives there, both away from the vertex, shape ``(m, 4, 2, 3)``. In
        regular sectors they are derivatives by the patch parameters, elsewhere
        tangents of a length close to that.
    normals : outward unit normals at the corners of the quads, shape ``(m, 4, 3)``.
        A corner with more than one quad between its sharp sides has no tangent
        plane in the limit: it gets that of :func:`crispline.spline.bezier.bezier_patches`.
        At a corner without sharp sides each quad has the normal of its own tangents.
    """

    position: Array
    tangents: Array
    normals: Array


def limit_points(net: CreasedNet) -> LimitPoints:
    """Limit positions, tangents and normals in closed form, without subdividing.

    Raises
    ------
    InputError
        If the net is no oriented surface, or two sheets of it touch in one vertex.

    References
    ----------
    Halstead, Kass and DeRose 1993; Hoppe et al. 1994 for creases.
    """
    points = corner_points(net)
    sectors = points.sectors
    require_single_fans(net, sectors)
    origin = points.position[net.quads.ravel()]
    outgoing, incoming = points.outgoing - origin, points.incoming - origin
    cross = np.cross(outgoing, incoming)
    # Alone in its sector, a quad at a crease is opened flat: its two sides leave in
    # opposite directions, and the plane is that of the crease and the quad's inside.
    is_flat = ((sectors.kind == Kind.CREASE) & (sectors.size == 1))[sectors.of_corner]
    inside = points.inner - origin
    bent = np.cross(outgoing - incoming, inside)
    normals = unit(np.where(is_flat[:, None], bent, cross))
    tangents = 3.0 * np.stack([outgoing, incoming], axis=1)
    m = len(net.quads)
    return LimitPoints(points.position, tangents.reshape(m, 4, 2, 3), normals.reshape(m, 4, 3))
