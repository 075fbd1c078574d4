"""The experiment's windows: one organised grid of points about each feature of the paper's model.

The paper analyses "each sharp feature separately in a bounding box of side length
equal to one-eighth that of the full model". A window here reaches one eighth of the
model's length (`REACH`, 8.75 spacings) from the feature on each face beside it, and is
as long along the feature. The model's unit is the spacing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.shapes.box_cylinder import HEIGHT, RADIUS, SIDE
from crispline.surface.base import Array, unit

Feature = Literal["straight", "lower circle", "upper circle", "corner"]
FEATURES: tuple[Feature, ...] = get_args(Feature)

REACH = SIDE / 8.0
"""How far a window reaches on each face beside the feature, and the length noise refers to."""
N_SAMPLES = 100
"""Points of the feature per window at which the error is measured; one at a corner."""
N_AROUND = 8
"""Windows around each circle, at equal angles."""

_HALF = SIDE / 2.0
_STEPS_AROUND = round(2.0 * np.pi * RADIUS)
_N_ROWS = int(REACH) + 1
_ROWS = np.arange(_N_ROWS, dtype=np.float64) - (_N_ROWS - 1) / 2.0
_PIXEL = 3.0**-0.25
"""Side of a pixel that covers a unit of area on a face seen along the corner's diagonal."""
_N_COURSE = 2001


@dataclass(frozen=True, eq=False)
class Window:
    """A grid of points about one feature, with what is exactly known of it.

    Attributes
    ----------
    feature : the kind of feature.
    points : shape ``(m, n, 3)``; NaN where a pixel of a range image is beyond the window.
    spacing : mean distance between neighbouring points on the surface.
    cell : side of the grid's cells as they are seen, a pixel at corners.
    samples : true points of the feature at equal steps, shape ``(k, 3)``.
    course : grid parameters (row, column) of the feature at dense steps along all its
        edges, shape ``(q, 2)``; parameter ``(i, j)`` belongs to grid point ``(i, j)``.
    """

    feature: Feature
    points: Array
    spacing: float
    cell: float
    samples: Array
    course: Array

    @property
    def is_patch(self) -> NDArray[np.bool_]:
        """Cells whose four points are there, shape ``(m - 1, n - 1)``."""
        valid = np.asarray(np.isfinite(self.points).all(axis=2))
        return valid[:-1, :-1] & valid[1:, :-1] & valid[:-1, 1:] & valid[1:, 1:]

    def noisy(self, level: float, stream: np.random.Generator) -> Window:
        """The window with every point moved in a random direction.

        Parameters
        ----------
        level : length of the step over `REACH` (the paper's percentage), 0 or more.
        stream : where the directions come from.
        """
        step = level * REACH * self.spacing * unit(stream.normal(size=self.points.shape))
        return replace(self, points=self.points + step)

    def scaled(self, factor: float) -> Window:
        """The window in another unit; ``factor`` is how many new units an old one is."""
        return replace(
            self,
            points=self.points * factor,
            spacing=self.spacing * factor,
            cell=self.cell * factor,
            samples=self.samples * factor,
        )


def windows(feature: Feature, phase: float) -> tuple[Window, ...]:
    """All windows of one kind: 12 straight edges, `N_AROUND` about a circle, 8 corners.

    Parameters
    ----------
    feature : see `FEATURES`.
    phase : position of the feature between two columns of points, in cells, 0 to 0.5:
        0 if a column lies on it, 0.5 if it runs midway. At corners the offset applies
        to rows and columns of the image.

    Raises
    ------
    InputError
        Unknown feature, or a phase outside 0 to 0.5.
    """
    if feature not in FEATURES:
        raise InputError(f"feature: expected one of {', '.join(FEATURES)}, got '{feature}'")
    if not 0.0 <= phase <= 0.5:
        raise InputError(
            f"phase: expected a position of 0 (a row of points on the edge) to 0.5 (midway "
            f"between two rows), got {phase}"
        )
    return tuple(_BUILDERS[feature](phase))


def _straight(phase: float) -> Iterator[Window]:
    """One window in the middle of each of the 12 edges of the box."""
    axes = np.eye(3)
    for axis, sign_b, sign_c in product(range(3), (-1.0, 1.0), (-1.0, 1.0)):
        b, c = axes[axis - 2] * sign_b, axes[axis - 1] * sign_c
        middle, along = _HALF * (b + c), axes[axis]

        def edge(t: Array, middle: Array = middle, along: Array = along) -> Array:
            return middle + t[:, None] * along

        inward = [np.broadcast_to(-side, (_N_ROWS, 3)) for side in (c, b)]
        yield _across("straight", edge, _ROWS, inward[0], inward[1], phase)


def _circle(feature: Feature, phase: float) -> Iterator[Window]:
    """Polar grids; columns run down or up the wall and over the plane beside it."""
    is_upper = feature == "upper circle"
    height = _HALF + (HEIGHT if is_upper else 0.0)
    down = -1.0 if is_upper else 1.0  # from the circle along the wall, and on the plane outward
    step = 2.0 * np.pi / _STEPS_AROUND
    for index in range(N_AROUND):
        middle = 2.0 * np.pi * index / N_AROUND
        angle = middle + step * _ROWS

        def rim(t: Array) -> Array:
            return np.column_stack(
                [RADIUS * np.cos(t), RADIUS * np.sin(t), np.full(len(t), height)]
            )

        radial = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(_N_ROWS)])
        wall = np.broadcast_to([0.0, 0.0, down], (_N_ROWS, 3))
        yield _across(feature, rim, angle, wall, down * radial, phase)


def _across(
    feature: Feature,
    curve: Callable[[Array], Array],
    rows: Array,
    first_side: Array,
    second_side: Array,
    phase: float,
) -> Window:
    """Grid with rows at parameters of a curve and columns at unit steps across it.

    ``first_side`` and ``second_side`` are the directions away from the curve on the two
    faces, one a row, shape ``(m, 3)``. The last column on the first face lies ``phase``
    from the curve.
    """
    n_first = int(REACH - phase) + 1
    n_second = int(REACH - (1.0 - phase)) + 1
    place = np.arange(n_first + n_second) - (n_first - 1) - phase
    away = np.where((place <= 0.0)[None, :, None], first_side[:, None, :], second_side[:, None, :])
    points = curve(rows)[:, None, :] + np.abs(place)[None, :, None] * away
    course = np.column_stack(
        [
            np.linspace(0.0, len(rows) - 1.0, _N_COURSE),
            np.full(_N_COURSE, n_first - 1 + phase),
        ]
    )
    samples = curve(np.linspace(rows[0], rows[-1], N_SAMPLES))
    return Window(feature, points, 1.0, 1.0, samples, course)


def _corners(phase: float) -> Iterator[Window]:
    """Range images of the box's corners along their diagonals, the vertical edge upright.

    Every other image has its rows offset the other way, as an upright edge makes
    columns symmetric but not rows.
    """
    right = np.array([-1.0, 1.0, 0.0]) / np.sqrt(2.0)
    up = np.array([-1.0, -1.0, 2.0]) / np.sqrt(6.0)
    n_beside = int(np.ceil(REACH / _PIXEL)) + 1
    ticks = np.arange(-n_beside, n_beside + 1)
    for index, signs in enumerate(product((-1.0, 1.0), repeat=3)):
        offset = np.array([phase if index % 2 == 0 else -phase, phase])
        x, y = np.meshgrid(ticks - offset[1], ticks - offset[0])
        image = _PIXEL * (x[..., None] * right + y[..., None] * up)
        # Along the line of sight the nearest point of the corner has largest component 0.
        inward = image - image.max(axis=2, keepdims=True)
        inward[inward.min(axis=2) < -REACH] = np.nan
        valid = np.isfinite(inward).all(axis=2)
        rows, columns = np.flatnonzero(valid.any(axis=1)), np.flatnonzero(valid.any(axis=0))
        origin = np.array([rows[0], columns[0]])
        inward = inward[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        corner = np.full(3, _HALF)
        edges = -np.linspace(0.0, REACH, _N_COURSE)[:, None, None] * np.eye(3)
        course = np.stack([edges @ up, edges @ right], axis=2).reshape(-1, 2) / _PIXEL
        mirror = np.array(signs)
        yield Window(
            "corner",
            (corner + inward) * mirror,
            1.0,
            _PIXEL,
            (corner * mirror)[None],
            course + offset + n_beside - origin,
        )


_BUILDERS: Mapping[Feature, Callable[[float], Iterator[Window]]] = {
    "straight": _straight,
    "lower circle": lambda phase: _circle("lower circle", phase),
    "upper circle": lambda phase: _circle("upper circle", phase),
    "corner": _corners,
}
