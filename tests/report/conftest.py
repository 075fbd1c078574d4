"""A cube with a report, and a browser to look at it."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crispline.brep.compose import make_solid
from crispline.curve import Line
from crispline.model import Edge, Face, Model
from crispline.net.halfedge import half_edges
from crispline.options import Options
from crispline.region.topology import border_topology
from crispline.report.html import write_report
from crispline.result import Reconstruction
from crispline.spline.creased import CreasedNet
from crispline.surface import Plane

_SPEC = importlib.util.spec_from_file_location("browser", Path(__file__).parent / "browser.py")
assert _SPEC is not None
assert _SPEC.loader is not None
_BROWSER = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(_BROWSER)

HALF = 10.0
OFF = 0.15
N_QUADS = 8


@pytest.fixture(scope="session")
def cube(nets):
    """A cube of side 20 about the origin: face ``2 k`` looks along -axis k, ``2 k + 1`` along +.

    Its cloud lies 0.15 outside on the +z face and inside on all others; its net has
    8 by 8 quads a side, those along the edges called sharp.
    """
    vertices, quads, side = nets.box(N_QUADS, half=HALF)
    topology = border_topology(half_edges(quads, len(vertices)), side)
    used = sorted({int(chain.vertices[end]) for chain in topology.chains for end in (0, -1)})
    edges = []
    for chain in topology.chains:
        a, b = vertices[chain.vertices[0]], vertices[chain.vertices[-1]]
        ends = used.index(chain.vertices[0]), used.index(chain.vertices[-1])
        line = Line(a, (b - a) / (2 * HALF), 0.0, 2 * HALF)
        edges.append(Edge(line, *ends, chain.left, chain.right, 1e-9, np.pi / 2, True))
    faces = []
    for k in range(6):
        normal = np.eye(3)[k // 2] * (1.0 if k % 2 else -1.0)
        off = np.full(400, OFF if k == 5 else -OFF)
        # Away from the edges the nearest face is the point's own.
        points = np.random.default_rng(k).uniform(0.5 - HALF, HALF - 0.5, (400, 3))
        surface = Plane(HALF * normal, normal)
        points = surface.project(points)[0] + off[:, None] * normal
        faces.append(Face(surface, 1, topology.loops[k], points, off, k))
    model = Model(vertices[used], np.zeros(8), tuple(edges), tuple(faces))
    pairs = [(c.vertices[:-1], c.vertices[1:]) for c in topology.chains]
    creases = np.concatenate([np.stack(pair, axis=1) for pair in pairs])
    at_edge = np.abs(vertices[quads]) > HALF - 1e-9
    kinds = np.where(at_edge.any(axis=1).sum(axis=1) > 1, 2, 0).astype(np.uint8)
    return Reconstruction(
        model=model,
        patches=CreasedNet(vertices, quads, creases, np.array(used)),
        spacing=1.0,
        noise=0.1,
        solid=make_solid(model, None, 1.0),
        timings={"net": 2.0, "fit": 0.5},
        warnings=(
            "12 points were left out <here>",
            "the surfaces of regions 1, 3, 5 have no common point near (10, 10, 10): gap",
        ),
        patch_kinds=kinds,
        plain_vertices=vertices,
    )


@pytest.fixture(scope="session")
def points(cube):
    return np.concatenate([face.points for face in cube.model.faces])


@pytest.fixture(scope="session")
def unbuilt(cube):
    """The cube of a run that made no solid."""
    return replace(cube, solid=None)


@pytest.fixture(scope="session")
def report(cube, points, tmp_path_factory):
    """Path of a written report of the cube."""
    path = tmp_path_factory.mktemp("report") / "cube.html"
    write_report(path, cube, points, title="cube & co", unit="mm", options=Options())
    return path


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """A headless Chromium with one page; tests are skipped where there is none."""
    program = _BROWSER.find_browser()
    if program is None or sys.platform == "win32":
        pytest.skip("no Chromium is installed; CRISPLINE_CHROMIUM may name one")
    browser = _BROWSER.Browser(program, tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()
