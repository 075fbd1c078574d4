"""One step over faces of any number of sides, against the rules written out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.errors import InputError
from crispline.spline.creased import CreasedNet, PolygonNet, subdivided

NONE = np.zeros((0, 2), dtype=np.int64)
NO_CORNERS = np.zeros(0, dtype=np.int64)

# A house: square walls and floor, two sloping rectangles, two triangles as gables.
HOUSE = [
    [3, 2, 1, 0],
    [0, 1, 5, 4],
    [2, 3, 7, 6],
    [1, 2, 6, 9, 5],
    [3, 0, 4, 8, 7],
    [4, 5, 9, 8],
    [6, 7, 8, 9],
]
TETRAHEDRON = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
OPEN = [[0, 1, 2], [0, 2, 3, 4], [2, 1, 5, 6, 7, 8]]


def polygon_net(faces, vertices, creases=NONE, corners=NO_CORNERS):
    sizes = np.array([len(face) for face in faces])
    return PolygonNet(vertices, np.concatenate(faces), sizes, np.asarray(creases), corners)


def naive_step(faces, p, creases, corners):
    """New points of vertices, sides and faces, by dictionary."""
    sides = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            sides.setdefault(frozenset((a, b)), []).append(f)
    marked = {frozenset(pair) for pair in np.asarray(creases).tolist()}
    sharp = {side for side, used in sides.items() if side in marked or len(used) != 2}
    face_point = [p[face].mean(axis=0) for face in faces]
    middle = {side: p[list(side)].mean(axis=0) for side in sides}
    edge_point = {
        side: middle[side]
        if side in sharp
        else (2 * middle[side] + face_point[used[0]] + face_point[used[1]]) / 4
        for side, used in sides.items()
    }
    vertex_point = []
    for v in range(len(p)):
        own = [side for side in sides if v in side]
        across = [next(iter(side - {v})) for side in own if side in sharp]
        if v in corners or len(across) > 2:
            vertex_point.append(p[v])
        elif len(across) == 2:
            vertex_point.append(0.75 * p[v] + 0.125 * (p[across[0]] + p[across[1]]))
        else:
            n = len(own)
            around = np.mean([face_point[f] for f, face in enumerate(faces) if v in face], axis=0)
            halfway = np.mean([middle[side] for side in own], axis=0)
            vertex_point.append((around + 2 * halfway + (n - 3) * p[v]) / n)
    return vertex_point, edge_point, face_point


@given(
    faces=st.sampled_from([HOUSE, TETRAHEDRON, OPEN]),
    seed=st.integers(0, 1000),
    share=st.sampled_from([0.0, 0.3, 0.7]),
    n_corners=st.integers(0, 2),
)
def test_one_step_follows_the_rules(faces, seed, share, n_corners):
    rng = np.random.default_rng(seed)
    n = 1 + max(max(face) for face in faces)
    vertices = rng.normal(size=(n, 3))
    sides = sorted(
        {tuple(sorted(s)) for face in faces for s in zip(face, face[1:] + face[:1], strict=True)}
    )
    creases = np.array([s for s in sides if rng.random() < share], dtype=int).reshape(-1, 2)
    corners = rng.choice(n, n_corners, replace=False)
    finer = subdivided(polygon_net(faces, vertices, creases, corners))
    vertex_point, edge_point, face_point = naive_step(faces, vertices, creases, corners)

    assert len(finer.quads) == sum(map(len, faces))
    half_edges = [
        (f, face[i - 1], face[i], face[(i + 1) % len(face)])
        for f, face in enumerate(faces)
        for i in range(len(face))
    ]
    for quad, (f, before, here, after) in zip(finer.quads, half_edges, strict=True):
        assert quad[0] == here
        expected = [
            vertex_point[here],
            edge_point[frozenset((here, after))],
            face_point[f],
            edge_point[frozenset((before, here))],
        ]
        np.testing.assert_allclose(finer.vertices[quad], expected, atol=1e-12)


def test_quads_may_be_given_either_way(nets):
    vertices, quads, _ = nets.box(2)
    plain = subdivided(CreasedNet(vertices, quads, NONE, NO_CORNERS))
    general = subdivided(polygon_net(quads.tolist(), vertices))
    for name in ("vertices", "quads", "creases", "corners"):
        np.testing.assert_array_equal(getattr(general, name), getattr(plain, name))


def test_impossible_faces_are_refused():
    with pytest.raises(InputError, match=r"face 1 has 2 sides: expected at least 3"):
        subdivided(polygon_net([[0, 1, 2], [0, 1]], np.eye(3)))
    net = PolygonNet(np.eye(3), np.arange(3), np.array([4]), NONE, NO_CORNERS)
    with pytest.raises(InputError, match=r"add up to 4, but 3 vertices are listed"):
        subdivided(net)
