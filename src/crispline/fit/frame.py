"""Local frames for small turns of an axis; called in every step of every fit, hence scalar."""

from __future__ import annotations

from math import copysign, sqrt

import numpy as np

from crispline.surface.base import Array


def frame_about(axis: Array) -> Array:
    """Right-handed orthonormal rows ``x, y, axis``, shape ``(3, 3)``.

    Duff et al. (2017), Building an orthonormal basis, revisited, listing 3.

    >>> frame_about(np.array([0.0, 0.0, 1.0])).tolist()
    [[1.0, -0.0, -0.0], [-0.0, 1.0, -0.0], [0.0, 0.0, 1.0]]
    """
    p, q, r = axis.tolist()
    sign = copysign(1.0, r)
    a = -1.0 / (sign + r)
    b = p * q * a
    return np.array(
        [[1.0 + sign * p * p * a, sign * b, -sign * p], [b, sign + q * q * a, -q], [p, q, r]]
    )


def tilted(frame: Array, tilt_x: float, tilt_y: float) -> Array:
    """The axis of a frame after small turns towards its ``x`` and ``y``, unit, shape ``(3,)``."""
    length = sqrt(1.0 + tilt_x * tilt_x + tilt_y * tilt_y)
    return np.asarray((frame[2] + tilt_x * frame[0] + tilt_y * frame[1]) / length)


def radial(offsets: Array, n_axes: int) -> tuple[Array, Array]:
    """Lengths ``(n,)`` of the first ``n_axes`` columns and the unit vectors ``(n, n_axes)`` back.

    The unit vector of a zero offset is zero.
    """
    across = offsets[:, :n_axes]
    length = np.sqrt(np.einsum("ij,ij->i", across, across))
    return length, across * (-1.0 / np.where(length > 0.0, length, 1.0))[:, None]
