"""Draw the paper's four figures from runs of this program.

python docs/paper_figures.py   # needs matplotlib and pyvista
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pyvista as pv
from matplotlib import pyplot as plt
from numpy.typing import NDArray
from PIL import Image
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

import crispline
from crispline.occt.measure import tessellate
from crispline.paper.grids import sharpened
from crispline.paper.patches import Patches, spline_patches
from crispline.paper.windows import FEATURES, Feature, Window, windows
from crispline.shapes import box_cylinder, sample
from crispline.spline.tensor import spline_over_grid
from crispline.surface.base import Array

HERE = Path(__file__).parent / "images"
EYE = (1.0, -1.6, 0.9)
CLOUD_NOISE = 0.01
COLOURS = {
    "straight": "#3a9d4f",
    "lower circle": "#ef8a2c",
    "upper circle": "#d43a2f",
    "corner": "#f2c230",
}
WINDOW_PHASE = 0.25
WINDOW_NOISE = 0.01
WINDOW_OF: dict[Feature, int] = {"straight": 3, "lower circle": 6, "upper circle": 6, "corner": 7}
N_FACETS = 8
GREY = "#c9d3dd"
INK = "#1d2833"


def main() -> None:
    """Draw all figures."""
    mpl.use("Agg")
    draw_repeated_points()
    draw_model()
    draw_before_and_after()


def draw_repeated_points() -> None:
    """Figure 1: a point once, twice and three times in a cubic B-spline curve."""
    corner = np.array([[0.0, 0.0], [0.2, 1.3], [2.0, 2.4], [3.8, 1.3], [4.0, 0.0]])
    figure, panels = plt.subplots(1, 3, figsize=(9.0, 2.3), sharey=True)
    for repeat, panel in zip((1, 2, 3), panels, strict=True):
        net = np.repeat(corner, [1, 1, repeat, 1, 1], axis=0)
        # Phantom ends, so that the curve runs from the first point to the last.
        net = np.vstack([2.0 * net[0] - net[1], net, 2.0 * net[-1] - net[-2]])
        knots = np.arange(-3.0, len(net) + 1.0)
        t = np.linspace(0.0, len(net) - 3.0, 801)
        curve = BSpline(knots, net, 3)(t)
        panel.plot(*corner.T, "--", color="#9aa7b4", lw=1.0)
        panel.plot(*curve.T, color="#2b6cb0", lw=2.2)
        panel.plot(*np.delete(corner, 2, axis=0).T, "o", color=INK, ms=4)
        panel.plot(*corner[2], "o", color="#d43a2f", ms=7)
        gap = np.linalg.norm(curve - corner[2], axis=1).min()
        title = ("once", "twice", "three times")[repeat - 1]
        panel.set_title(f"{title}: {gap:.2f} away" if gap > 1e-9 else f"{title}: on the curve")
        panel.set_aspect("equal")
        panel.set_axis_off()
    figure.subplots_adjust(0.0, 0.02, 1.0, 0.88, 0.0)
    figure.savefig(HERE / "paper-repeated-points.png", dpi=110)
    plt.close(figure)


def draw_model() -> None:
    """Figures 2 and 3: the cloud, and the features found in it."""
    scan = sample(box_cylinder(), 34_000, noise=CLOUD_NOISE)
    result = crispline.reconstruct(scan.points)
    assert result.solid is not None
    mesh = tessellate(result.solid.shape, 0.02 * result.spacing, 0.05)
    body = surface(mesh.vertices, mesh.triangles)

    # A body that is a little thinner hides the points on the far side.
    normals = body.compute_normals(split_vertices=False, consistent_normals=False).point_data
    thinner = mesh.vertices - 0.5 * result.spacing * normals["Normals"]
    plotter = view()
    plotter.add_mesh(surface(thinner, mesh.triangles), color="white", lighting=False)
    light = np.array([-0.35, -0.45, 0.82])  # shaded, as bare points do not show their shape
    shade = np.clip(0.35 + 0.65 * scan.normals @ light, 0.0, 1.0)
    tones = mpl.colormaps["Blues"](0.95 - 0.5 * shade)[:, :3]
    plotter.add_points(scan.points, scalars=tones, rgb=True, point_size=3.2)
    save(plotter, "paper-cloud.png")

    plotter = view()
    plotter.add_mesh(body, color="#e4eaf0", ambient=0.55, diffuse=0.5)
    radius = 0.55 * result.spacing
    for edge in result.edges:
        if not edge.is_sharp:
            continue
        height = edge.points[:, 2].mean()
        kind = "straight" if edge.kind == "line" else "lower circle"
        if kind == "lower circle" and height > 50.0:
            kind = "upper circle"
        tube = pv.lines_from_points(edge.points).tube(radius=radius, n_sides=16)
        plotter.add_mesh(tube, color=COLOURS[kind], ambient=0.4)
    for corner in result.corners:
        ball = pv.Sphere(radius=2.2 * radius, center=corner, theta_resolution=24, phi_resolution=24)
        plotter.add_mesh(ball, color=COLOURS["corner"], ambient=0.4)
    save(plotter, "paper-features.png")


def draw_before_and_after() -> None:
    """Figure 4: every kind of feature, the plain surface and the sharpened one."""
    plotter = pv.Plotter(
        off_screen=True, window_size=(900, 1480), shape=(len(FEATURES), 2), border=False
    )
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    for row, feature in enumerate(FEATURES):
        window = windows(feature, WINDOW_PHASE)[WINDOW_OF[feature]]
        noisy = window.noisy(WINDOW_NOISE, np.random.default_rng(1))
        sharp, is_sharp = sharpened(noisy.points, "robust")
        plain = spline_patches(spline_over_grid(noisy.points))
        for column, patches in enumerate((plain, sharp)):
            plotter.subplot(row, column)
            draw_patches(plotter, patches, noisy, is_sharp)
    write_picture(plotter.screenshot(return_img=True), "paper-before-after.png")
    plotter.close()


def draw_patches(
    plotter: pv.Plotter, patches: Patches, window: Window, is_sharp: NDArray[np.bool_]
) -> None:
    """Patches with their borders; red those that lie where sharp ones were found."""
    corners = [window.points[i : i - 1 or None, j : j - 1 or None] for i in (0, 1) for j in (0, 1)]
    cells = np.mean(corners, axis=0)
    nearest = cKDTree(cells[window.is_patch]).query(patches.samples(1)[0])[1]
    is_red = is_sharp[window.is_patch][nearest]
    points = patches.evaluate(*patches.lattice(N_FACETS + 1, with_borders=True))
    points = points.reshape(-1, N_FACETS + 1, N_FACETS + 1, 3)
    for chosen, colour in ((~is_red, GREY), (is_red, COLOURS["upper circle"])):
        for facets in points[chosen]:
            mesh = pv.StructuredGrid(*facets.transpose(2, 0, 1)[..., None])
            look = {"color": colour, "ambient": 0.45, "diffuse": 0.6, "smooth_shading": True}
            plotter.add_mesh(mesh, **look)
            rim = [facets[0], facets[1:, -1], facets[-1, -2::-1], facets[-2::-1, 0]]
            border = pv.lines_from_points(np.concatenate(rim)).tube(radius=0.025, n_sides=6)
            plotter.add_mesh(border, color="#3f4d5a", lighting=False)
    x, y, _ = window.samples.mean(axis=0)
    outward = np.array([x, y, np.hypot(x, y)])
    plotter.view_vector(outward + 0.6 * np.array([-y, x, 0.0]), (0.0, 0.0, 1.0))
    plotter.enable_parallel_projection()
    plotter.camera.zoom(1.2)


def surface(vertices: Array, triangles: NDArray[np.int64]) -> pv.PolyData:
    """A triangle mesh."""
    faces = np.column_stack([np.full(len(triangles), 3), triangles])
    return pv.PolyData(vertices, faces.ravel())


def view() -> pv.Plotter:
    """An empty picture of the whole model."""
    plotter = pv.Plotter(off_screen=True, window_size=(760, 820))
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    plotter.enable_parallel_projection()
    return plotter


def save(plotter: pv.Plotter, name: str) -> None:
    """Look along `EYE` and write the picture."""
    plotter.view_vector(EYE, (0.0, 0.0, 1.0))
    plotter.camera.zoom(1.12)
    write_picture(plotter.screenshot(return_img=True), name)
    plotter.close()


def write_picture(pixels: NDArray[np.uint8], name: str) -> None:
    """Write a PNG of few colours, which is small."""
    Image.fromarray(pixels).quantize(200, dither=Image.Dither.NONE).save(HERE / name, optimize=True)


if __name__ == "__main__":
    main()
