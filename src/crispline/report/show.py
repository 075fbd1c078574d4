"""A reconstruction in a window of its own, by PyVista (extra ``view``)."""

from __future__ import annotations

from typing import Any

import numpy as np

from crispline.extras import optional
from crispline.report.palette import KIND_COLOURS, KINDS, RAMP, kind_index
from crispline.report.scene import Scene, scene_of
from crispline.result import Reconstruction
from crispline.surface.base import Array


def show(result: Reconstruction, points: Array | None = None, **options: Any) -> Any:
    """Open a window (in a notebook, a view) with the model and, if given, the cloud.

    Parameters
    ----------
    result : complete or partial.
    points : coloured by their deviation from the model, shape ``(n, 3)``; None for no cloud.
    options : passed on to ``pyvista.Plotter.show``, for example ``screenshot="part.png"``.

    Returns
    -------
    What ``pyvista.Plotter.show`` returns.

    Raises
    ------
    InputError
        PyVista is not installed.
    """
    return plotter(result, points).show(**options)


def plotter(result: Reconstruction, points: Array | None = None, **options: Any) -> Any:
    """The ``pyvista.Plotter`` that :func:`show` shows, to add things to.

    Faces are coloured by type, sharp edges are black; ``options`` go to the plotter,
    for example ``off_screen=True``.

    Raises
    ------
    InputError
        PyVista is not installed.
    """
    pv = optional("pyvista", "view", "showing a model")
    cloud = np.zeros((0, 3)) if points is None else points
    is_measured = points is not None and result.solid is not None
    scene = scene_of(result, cloud, result.deviations(cloud) if is_measured else None)
    window = pv.Plotter(**options)
    _add_model(pv, window, scene, [kind_index(face.kind) for face in result.faces])
    for lines, colour in ((scene.sharp_edges, "black"), (scene.tangent_edges, "grey")):
        for line in lines:
            window.add_lines(line, color=colour, width=3, connected=True)
    if len(scene.corners):
        window.add_points(
            scene.corners, color="black", point_size=10, render_points_as_spheres=True
        )
    if points is not None:
        _add_cloud(window, scene, 3.0 * result.noise)
    window.add_axes()
    return window


def _add_model(pv: Any, window: Any, scene: Scene, kinds: list[int]) -> None:
    mesh = scene.mesh
    of_row = np.array([*kinds, len(KINDS) - 1])  # the last stands for faces without a row
    of_triangle = of_row[mesh.faces]
    for kind in np.unique(of_triangle):
        part = pv.PolyData.from_regular_faces(mesh.vertices, mesh.triangles[of_triangle == kind])
        window.add_mesh(
            part,
            color=KIND_COLOURS[kind],
            label=KINDS[kind],
            smooth_shading=True,
            split_sharp_edges=True,
        )


def _add_cloud(window: Any, scene: Scene, limit: float) -> None:
    from matplotlib.colors import LinearSegmentedColormap

    known = np.isfinite(scene.cloud.deviations)
    window.add_points(
        scene.cloud.points[known],
        scalars=scene.cloud.deviations[known],
        cmap=LinearSegmentedColormap.from_list("deviation", RAMP),
        clim=(-limit, limit),
        point_size=4,
        scalar_bar_args={"title": "deviation"},
    )
    if not known.all():
        window.add_points(scene.cloud.points[~known], color="grey", point_size=4)
