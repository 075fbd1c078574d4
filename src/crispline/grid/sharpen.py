"""The paper's method on a grid or a B-spline surface."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crispline.exchange.mesh import tessellate
from crispline.grid.chains import polylines
from crispline.grid.detect import curvature, detect
from crispline.grid.lattice import Mask, Surface, as_lattice
from crispline.grid.locate import locate
from crispline.grid.preserve import preserve, resampling_error
from crispline.options import SharpenOptions
from crispline.spline.creased import PolygonNet, subdivided
from crispline.spline.limit import limit_points
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array


@dataclass(frozen=True)
class Sharpened:
    """A surface with sharp edges and corners, and what was found on the way.

    Lengths are in the unit of the input. Masks have one entry for each patch, shape
    ``(m - 1, n - 1)``.

    Attributes
    ----------
    surface : a tensor product where every edge crosses it along rows or columns, else
        a control net with creases.
    has_patch : cells with four valid points.
    is_curved : curvature above the threshold or sharp.
    is_sharp : an edge runs through the patch.
    located : points of the edges and corners, shape ``(k, 3)``.
    edges : polylines, each of shape ``(k, 3)``; a closed one repeats its first point.
    corners : shape ``(c, 3)``.
    spacing : root of the median area of a patch.
    noise : standard deviation along the normals.
    eps : smallest curvature called curved, 1/length.
    rule : ``robust`` or ``paper``.
    resampling_error : how far a given surface moved away from its edges when it was
        brought to a uniform net; 0 if it was not.
    """

    surface: TensorSpline | PolygonNet
    has_patch: Mask
    is_curved: Mask
    is_sharp: Mask
    located: Array
    edges: tuple[Array, ...]
    corners: Array
    spacing: float
    noise: float
    eps: float
    rule: str
    resampling_error: float = 0.0

    @property
    def is_tensor_product(self) -> bool:
        """Whether the result is one tensor-product surface."""
        return isinstance(self.surface, TensorSpline)

    def mesh(self, level: int = 3) -> tuple[Array, NDArray[np.int64]]:
        """Triangles over the surface with vertices on every edge and corner.

        Parameters
        ----------
        level : each patch has ``2**level`` steps a side.

        Returns
        -------
        vertices : on the surface, shape ``(n, 3)``.
        triangles : shape ``(t, 3)``, counter-clockwise about ``S_u x S_v``.
        """
        if isinstance(self.surface, TensorSpline):
            return tessellate(self.surface, 2**level)
        refined = subdivided(self.surface)
        for _ in range(level - 1):
            refined = subdivided(refined)
        quads = refined.quads
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return limit_points(refined).position, triangles

    def summary(self) -> dict[str, Any]:
        """Everything known of the result, ready for JSON."""
        return {
            "rule": self.rule,
            "kind": "tensor product" if self.is_tensor_product else "creased net",
            "spacing": self.spacing,
            "noise": self.noise,
            "eps": self.eps * self.spacing,
            "resampling_error": self.resampling_error,
            "patches": {
                "flat": int((self.has_patch & ~self.is_curved).sum()),
                "curved": int((self.is_curved & ~self.is_sharp).sum()),
                "sharp": int(self.is_sharp.sum()),
            },
            "n_located": len(self.located),
            "n_edges": len(self.edges),
            "n_corners": len(self.corners),
            "located": self.located.tolist(),
            "edges": [{"points": edge.tolist()} for edge in self.edges],
            "corners": self.corners.tolist(),
        }

    def write(self, path: str | PathLike[str], unit: str = "mm") -> None:
        """Write the surface; see :func:`crispline.grid.write.write_sharpened`."""
        from crispline.grid.write import write_sharpened  # OCCT is slow to import

        write_sharpened([self], path, unit)


def sharpen(surface: Surface, options: SharpenOptions | None = None) -> Sharpened:
    """Sharpen the edges and corners of organised points or a B-spline surface.

    Parameters
    ----------
    surface : organised points, shape ``(m, n, 3)``, not finite at invalid pixels: the
        control net of a uniform bicubic surface. Or a bicubic B-spline surface.
    options : see :class:`crispline.options.SharpenOptions`.

    Raises
    ------
    InputError
        The surface cannot be used.

    Examples
    --------
    >>> i, j = np.mgrid[:12, :12].astype(float)
    >>> roof = np.stack([i, j, -abs(j - 5.5)], axis=2)
    >>> sharpen(roof).summary()["patches"]
    {'flat': 88, 'curved': 22, 'sharp': 11}
    """
    options = options or SharpenOptions()
    lattice = as_lattice(surface)
    bend = curvature(lattice)
    detection = detect(lattice, bend, options)
    located = locate(lattice, detection, options)
    result = preserve(lattice, located, options)
    if located.lines is not None:
        edges = [line.points for line in located.lines]
    else:
        edges = polylines(located.crossings, located.corners, detection.has_patch.shape)
    corners = located.corners.points[located.corners.is_corner]
    points = np.concatenate([*edges, located.corners.points]) if edges else corners
    return Sharpened(
        surface=result,
        has_patch=detection.has_patch,
        is_curved=detection.is_curved | located.is_sharp,
        is_sharp=located.is_sharp,
        located=lattice.to_input(np.unique(points, axis=0)),
        edges=tuple(lattice.to_input(edge) for edge in edges),
        corners=lattice.to_input(corners),
        spacing=lattice.spacing,
        noise=detection.noise.normal * lattice.spacing,
        eps=detection.threshold / lattice.spacing,
        rule=options.rule,
        resampling_error=resampling_error(lattice, located),
    )
