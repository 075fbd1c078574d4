"""Windows and figures of a reconstruction."""

import sys

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from crispline.errors import InputError
from crispline.report import figures
from crispline.report.palette import KIND_COLOURS, PATCH_COLOURS


def colours_in(figure):
    """Share of the pixels of a figure that are not white, and their mean colour."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3].reshape(-1, 3).astype(float)
    inked = pixels[(pixels < 250).any(axis=1)]
    return len(inked) / len(pixels), inked


def rgb(colour):
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])


def is_like(pixels, colour, limit=0.05):
    unit = pixels / np.maximum(np.linalg.norm(pixels, axis=1), 1.0)[:, None]
    return np.linalg.norm(unit - rgb(colour) / np.linalg.norm(rgb(colour)), axis=1) < limit


def test_the_model_is_drawn_in_the_colour_of_its_kind_with_its_edges(cube):
    share, pixels = colours_in(figures.model(cube))
    assert 0.15 < share < 0.8
    assert np.mean(is_like(pixels, KIND_COLOURS[0])) > 0.8
    dark = np.mean(pixels.max(axis=1) < 90)
    assert 0.002 < dark < 0.1


def test_edges_behind_the_part_are_not_drawn(cube):
    (lines,) = [c for c in figures.model(cube).axes[0].collections if "Line" in type(c).__name__]
    middles = np.mean(lines._segments3d, axis=1)
    # From above, the front and the right, the corner (-10, 10, -10) is hidden.
    to_hidden = np.linalg.norm(middles - [-10.0, 10.0, -10.0], axis=1)
    assert to_hidden.min() > 9.0
    assert np.linalg.norm(middles - [10.0, -10.0, 10.0], axis=1).min() < 0.5


@pytest.mark.parametrize("is_sharp", [True, False])
def test_patches_have_the_colours_of_their_kinds(cube, is_sharp):
    _, pixels = colours_in(figures.patches(cube, is_sharp))
    for kind, low in ((0, 0.2), (2, 0.2)):
        assert np.mean(is_like(pixels, PATCH_COLOURS[kind])) > low


def test_curvature_is_high_along_the_edges_only(cube):
    figure = figures.curvature(cube)
    (faces,) = figure.axes[0].collections
    flat = np.median(faces.get_facecolor()[:, 2])  # viridis: zero is violet
    assert flat > 0.2
    assert figure.axes[1].get_ylabel().startswith("mean curvature")


def test_the_cloud_and_its_regions(cube, unbuilt, points):
    for figure in (figures.cloud(cube, points), figures.cloud(unbuilt, points)):
        assert len(figure.axes[0].collections[0].get_offsets()) == len(points)
    assert len(figures.regions(cube).axes[0].collections) == 6


def test_what_is_not_there_cannot_be_drawn(unbuilt):
    with pytest.raises(InputError, match="got none"):
        figures.model(unbuilt)


def test_a_missing_package_is_named(cube, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(InputError, match=r"crispline\[view\]"):
        cube.show()
    with pytest.raises(InputError, match=r"crispline\[figures\]"):
        figures.model(cube)


@pytest.mark.filterwarnings("ignore")
def test_the_window_holds_model_edges_corners_and_cloud(cube, points):
    pytest.importorskip("pyvista")
    from crispline.report.show import plotter

    window = plotter(cube, points, off_screen=True)
    sizes = sorted(actor.mapper.dataset.n_points for actor in window.actors.values()
                   if hasattr(actor, "mapper") and hasattr(actor.mapper, "dataset"))  # fmt: skip
    window.close()
    assert 2400 in sizes  # the cloud
    assert 8 in sizes  # the corners
    assert len(sizes) >= 3 + 12
