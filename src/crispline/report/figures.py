"""Pictures of the stages for papers, by matplotlib (extra ``figures``).

Every function draws one stage of a reconstruction and returns a ``Figure``:

>>> from crispline.report import figures
>>> figures.model  # doctest: +ELLIPSIS
<function model at ...>
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.extras import optional
from crispline.gauge.deviation import sample_triangles
from crispline.report.palette import KIND_COLOURS, PATCH_COLOURS, RAMP, kind_index
from crispline.report.scene import Patches, model_mesh, patches_of
from crispline.result import Reconstruction
from crispline.sharp.curvature import curvature as mean_curvature
from crispline.spline.catmull_clark import patch_centres
from crispline.surface.base import Array, unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VIEW = (26.0, -54.0)
"""Elevation and azimuth of the eye, degrees."""
_LIGHT = (0.3, 0.2, 0.5)
_MAX_POINTS = 60_000


def cloud(result: Reconstruction, points: Array, view: tuple[float, float] = VIEW) -> Figure:
    """The points, shape ``(n, 3)``, coloured by their deviation if there is a model."""
    shown = points[:: max(1, len(points) // _MAX_POINTS)]
    figure, axes = _empty(shown, view)
    if result.solid is None:
        axes.scatter(*shown.T, s=3.0, c="#4a5a68", linewidths=0)
        return figure
    colours = optional("matplotlib.colors", "figures", "figures")
    ramp = colours.LinearSegmentedColormap.from_list("deviation", RAMP)
    distance, limit = result.deviations(shown).distance, 3.0 * result.noise
    marks = axes.scatter(
        *shown.T, s=3.0, c=distance, cmap=ramp, vmin=-limit, vmax=limit, linewidths=0
    )
    figure.colorbar(marks, ax=axes, shrink=0.5, label="deviation")
    return figure


def curvature(result: Reconstruction, view: tuple[float, float] = VIEW) -> Figure:
    """Mean curvature at the patches of the plain surface, over the spacing."""
    net = _patches(result)
    centres = patch_centres(result.plain_vertices, net.quads)
    bend = np.abs(mean_curvature(centres)) * result.spacing
    matplotlib = optional("matplotlib", "figures", "figures")
    top = float(np.quantile(bend, 0.98))
    scale = matplotlib.colors.Normalize(0.0, top)
    mapped = matplotlib.cm.ScalarMappable(scale, "viridis")
    figure, axes = _empty(net.plain, view)
    _shade(axes, net.plain[net.quads], centres.normal, mapped.to_rgba(bend)[:, :3], view)
    figure.colorbar(mapped, ax=axes, shrink=0.5, label="mean curvature x spacing", extend="max")
    return figure


def patches(
    result: Reconstruction, is_sharp: bool = True, view: tuple[float, float] = VIEW
) -> Figure:
    """Flat, curved and sharp patches of the sharpened or of the plain surface."""
    net = _patches(result)
    positions = net.sharp if is_sharp else net.plain
    figure, axes = _empty(positions, view)
    corners = positions[net.quads]
    normals = unit(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]))
    _shade(axes, corners, normals, _rgb(PATCH_COLOURS)[net.kinds], view)
    return figure


def regions(result: Reconstruction, view: tuple[float, float] = VIEW) -> Figure:
    """The raw points of every face in a colour of its own."""
    matplotlib = optional("matplotlib", "figures", "figures")
    faces = result.model.faces
    if not faces:
        raise InputError("regions: expected a model with faces, got none; see its warnings")
    figure, axes = _empty(np.concatenate([face.points for face in faces]), view)
    wheel = matplotlib.colormaps["tab20"].colors
    for index, face in enumerate(faces):
        axes.scatter(*face.points.T, s=3.0, color=wheel[index % len(wheel)], linewidths=0)
    return figure


def model(result: Reconstruction, view: tuple[float, float] = VIEW) -> Figure:
    """Faces coloured by type."""
    if result.solid is None:
        raise InputError("model: expected a reconstruction with a solid, got none")
    order = np.array(result.solid.face_order, dtype=np.int64)
    mesh = model_mesh(result.solid.shape, result.spacing, order)
    kinds = [kind_index(face.surface.kind) for face in result.model.faces]
    kind = np.array([*kinds, len(KIND_COLOURS) - 1])[mesh.faces]
    corners = mesh.vertices[mesh.triangles]
    normals = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    figure, axes = _empty(mesh.vertices, view)
    _shade(axes, corners, normals, _rgb(KIND_COLOURS)[kind], view)
    lines = [edge.curve.samples(200) for edge in result.model.edges if edge.is_sharp]
    if lines:
        pieces = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
        samples, _ = sample_triangles(mesh, 0.3 * result.spacing)
        is_seen = _in_sight(pieces.mean(axis=1), samples, result.spacing, view)
        art3d = optional("mpl_toolkits.mplot3d.art3d", "figures", "figures")
        axes.add_collection3d(
            art3d.Line3DCollection(pieces[is_seen], colors="#1d2833", linewidths=1.1, zorder=10)
        )
    return figure


def _patches(result: Reconstruction) -> Patches:
    found = patches_of(result)
    if found is None:
        raise InputError("patches: expected a reconstruction with its plain net, got none")
    return found


def _rgb(colours: tuple[str, ...]) -> Array:
    return np.array([[int(c[i : i + 2], 16) / 255.0 for i in (1, 3, 5)] for c in colours])


def _empty(places: Array, view: tuple[float, float]) -> tuple[Figure, Any]:
    """A figure with one 3D panel that fits the places, without frame."""
    figure = optional("matplotlib.figure", "figures", "figures").Figure(figsize=(6.0, 5.0), dpi=200)
    optional("mpl_toolkits.mplot3d", "figures", "figures")
    axes = figure.add_axes((0.0, 0.0, 0.9, 1.0), projection="3d")
    low, high = places.min(axis=0), places.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.1)
    axes.view_init(*view)
    axes.set_axis_off()
    return figure, axes


def _frame(view: tuple[float, float]) -> Array:
    """Unit vectors to the right, up, and to the eye, as rows."""
    elevation, azimuth = np.radians(view)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    flat = np.cos(elevation)
    eye = np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
    return np.stack([right, np.cross(eye, right), eye])


def _in_sight(
    points: Array, samples: Array, spacing: float, view: tuple[float, float]
) -> NDArray[np.bool_]:
    """Whether no sample lies more than 2 spacings before a point, by a depth buffer."""
    frame = _frame(view)
    seen, hidden = samples @ frame.T, points @ frame.T
    origin = np.minimum(seen.min(axis=0), hidden.min(axis=0))[:2]
    cells = [((x[:, :2] - origin) / (0.6 * spacing)).astype(np.int64) for x in (seen, hidden)]
    shape = np.maximum(cells[0].max(axis=0), cells[1].max(axis=0)) + 1
    nearest = np.full(shape, -np.inf)
    np.maximum.at(nearest, tuple(cells[0].T), seen[:, 2])
    return np.asarray(hidden[:, 2] > nearest[tuple(cells[1].T)] - 2.0 * spacing)


def _shade(
    axes: Any, polygons: Array, normals: Array, colours: Array, view: tuple[float, float]
) -> None:
    """Add lit polygons; those that face away are left out."""
    eye = _frame(view)[2]
    lit = 0.55 + 0.45 * np.clip(normals @ unit(eye + np.array(_LIGHT)), 0.0, 1.0)
    front = normals @ eye > -0.05
    art3d = optional("mpl_toolkits.mplot3d.art3d", "figures", "figures")
    shaded = np.clip(colours * lit[:, None], 0.0, 1.0)[front]
    axes.computed_zorder = False
    axes.add_collection3d(
        art3d.Poly3DCollection(polygons[front], facecolors=shaded, linewidths=0, antialiaseds=False)
    )
