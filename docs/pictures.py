"""Draw the pictures of the documentation from the bundled scan.

python docs/pictures.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import NDArray

import crispline
from crispline.brep.measure import tessellate
from crispline.cloud.working import working_cloud
from crispline.net.halfedge import half_edges
from crispline.net.orientation import oriented_normals
from crispline.net.quads import quad_net
from crispline.options import Options
from crispline.sharp.curvature import curvature
from crispline.sharp.detect import detect
from crispline.spline.catmull_clark import patch_centres
from crispline.surface.base import Array

HERE = Path(__file__).parent
VIEW = (32.0, -55.0)  # elevation and azimuth, degrees
COLOURS = {
    "plane": "#8fb3d9",
    "cylinder": "#9fd3a5",
    "cone": "#e6c27a",
    "sphere": "#d9a0c0",
    "torus": "#b5a3dc",
    "bspline": "#f0a884",
}


def main() -> None:
    """Draw the bundled scan, its sharp patches and its model side by side."""
    mpl.use("Agg")
    scan = crispline.read_points(HERE.parent / "examples" / "bracket.ply")
    result = crispline.reconstruct(scan)
    figure = plt.figure(figsize=(15, 5))
    panels = [figure.add_subplot(1, 3, i + 1, projection="3d") for i in range(3)]
    draw_cloud(panels[0], scan.points)
    draw_sharp_patches(panels[1], scan.points)
    draw_model(panels[2], result)
    low, high = np.quantile(scan.points, [0.002, 0.998], axis=0)
    for panel in panels:
        panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        panel.set_box_aspect(high - low, zoom=1.05)
        panel.view_init(*VIEW)
        panel.set_axis_off()
    figure.subplots_adjust(0, 0, 1, 1, 0, 0)
    figure.savefig(HERE / "images" / "bracket.png", dpi=90)


def draw_cloud(panel: Axes, points: Array) -> None:
    """Every point of the scan that faces the eye or not; outliers too."""
    panel.scatter(*points.T, s=0.25, c="#30506f", linewidths=0, depthshade=False)


def draw_sharp_patches(panel: Axes, points: Array) -> None:
    """The quad net with flat, curved and sharp patches."""
    options = Options()
    cloud = working_cloud(points, options.cloud)
    net = quad_net(cloud, oriented_normals(cloud, options.net)[0], options.net)
    centres = patch_centres(net.vertices, net.quads)
    quads = half_edges(net.quads, len(net.vertices))
    found = detect(
        curvature(centres), centres.normal, quads.adjacency(), net.edge_length,
        max(cloud.sigma, options.fit.sigma_floor), options.detect,
    )  # fmt: skip
    colour = np.tile(mpl.colors.to_rgb("#c9d3dd"), (len(net.quads), 1))
    colour[found.is_curved] = mpl.colors.to_rgb("#f2d06b")
    colour[found.is_sharp] = mpl.colors.to_rgb("#d43a2f")
    vertices = cloud.to_user.points(net.vertices)
    shade_polygons(panel, vertices[net.quads], cloud.to_user.directions(centres.normal), colour)


def draw_model(panel: Axes, result: crispline.Reconstruction) -> None:
    """Faces coloured by kind, sharp edges in black."""
    assert result.solid is not None
    mesh = tessellate(result.solid.shape, 0.1 * result.spacing, 0.1)
    kinds = [result.model.faces[i].surface.kind for i in result.solid.face_order]
    colour = np.array([mpl.colors.to_rgb(COLOURS[kinds[face]]) for face in mesh.faces])
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    shade_polygons(panel, corners, normals, colour)
    ends = [edge.curve.samples(200) for edge in result.model.edges if edge.is_sharp]
    pieces = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in ends])
    visible = in_sight(pieces.mean(axis=1), corners, result.spacing)
    panel.add_collection3d(
        Line3DCollection(pieces[visible], colors="#1d2833", linewidths=1.1, zorder=10)
    )


def in_sight(points: Array, triangles: Array, spacing: float) -> NDArray[np.bool_]:
    """Whether nothing of the mesh lies between the points and the eye, by a depth buffer."""
    rng = np.random.default_rng(0)
    area = np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
    )
    chosen = triangles[rng.choice(len(triangles), 2_000_000, p=area / area.sum())]
    weight = rng.dirichlet(np.ones(3), len(chosen))
    samples = np.einsum("nk,nkd->nd", weight, chosen)
    right, up, eye = view_axes()
    pixel = spacing / 2.0
    cells = [np.round(x @ np.stack([right, up]).T / pixel).astype(int) for x in (samples, points)]
    origin = np.minimum(*(cell.min(axis=0) for cell in cells))
    shape = np.maximum(*(cell.max(axis=0) for cell in cells)) - origin + 1
    nearest = np.full(shape, -np.inf)
    np.maximum.at(nearest, tuple((cells[0] - origin).T), samples @ eye)
    return np.asarray(points @ eye > nearest[tuple((cells[1] - origin).T)] - 2.0 * spacing)


def view_axes() -> tuple[Array, Array, Array]:
    """Unit vectors to the right, up, and to the eye."""
    elevation, azimuth = np.radians(VIEW)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    flat = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    eye = np.cos(elevation) * flat + np.sin(elevation) * np.array([0.0, 0.0, 1.0])
    return right, np.cross(eye, right), eye


def shade_polygons(panel: Axes, polygons: Array, normals: Array, colour: Array) -> None:
    """Add lit polygons; those that face away are left out."""
    _, _, eye = view_axes()
    light = eye + np.array([0.3, 0.2, 0.5])
    lit = 0.55 + 0.45 * np.clip(normals @ (light / np.linalg.norm(light)), 0.0, 1.0)
    front = normals @ eye > -0.05
    shaded = np.clip(colour * lit[:, None], 0.0, 1.0)[front]
    panel.computed_zorder = False
    panel.add_collection3d(
        Poly3DCollection(polygons[front], facecolors=shaded, linewidths=0, antialiaseds=False)
    )


if __name__ == "__main__":
    main()
