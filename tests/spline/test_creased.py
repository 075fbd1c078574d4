"""One subdivision step against the rules written out vertex by vertex."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from crispline.spline.creased import CreasedNet, subdivided

NONE = np.zeros((0, 2), dtype=np.int64)


def sides_of(quads):
    """Every side with the faces that use it."""
    sides = {}
    for face, quad in enumerate(quads.tolist()):
        for k in range(4):
            side = frozenset((quad[k], quad[(k + 1) % 4]))
            sides.setdefault(side, []).append(face)
    return sides


def naive_step(net):
    """New vertices by the rules of DeRose, Kass and Truong, as dictionaries of points."""
    p, sides = net.vertices, sides_of(net.quads)
    creases = {frozenset(pair) for pair in net.creases.tolist()}
    sharp = {side for side, faces in sides.items() if side in creases or len(faces) == 1}
    face_point = [sum(p[v] for v in quad) / 4 for quad in net.quads.tolist()]
    edge_point = {}
    for side, faces in sides.items():
        a, b = side
        if side in sharp:
            edge_point[side] = (p[a] + p[b]) / 2
        else:
            edge_point[side] = (p[a] + p[b] + face_point[faces[0]] + face_point[faces[1]]) / 4
    vertex_point = []
    for v in range(len(p)):
        own = [side for side in sides if v in side]
        across = [next(iter(side - {v})) for side in own if side in sharp]
        faces = [f for f, quad in enumerate(net.quads.tolist()) if v in quad]
        n = len(own)
        if v in net.corners or len(across) > 2:
            vertex_point.append(p[v])
        elif len(across) == 2:
            vertex_point.append((6 * p[v] + p[across[0]] + p[across[1]]) / 8)
        else:
            mean_face = sum(face_point[f] for f in faces) / len(faces)
            mean_middle = sum((p[a] + p[b]) / 2 for a, b in own) / n
            vertex_point.append((mean_face + 2 * mean_middle + (n - 3) * p[v]) / n)
    return vertex_point, edge_point, face_point


def shape(nets, name):
    if name == "box":
        return nets.box(2)[:2]
    return nets.plane(4, 3) if name == "open" else nets.torus(4, 3)


@given(
    name=st.sampled_from(["box", "open", "torus"]),
    seed=st.integers(0, 1000),
    share=st.sampled_from([0.0, 0.2, 0.6]),
    n_corners=st.integers(0, 3),
)
def test_one_step_follows_the_rules(nets, name, seed, share, n_corners):
    rng = np.random.default_rng(seed)
    vertices, quads = shape(nets, name)
    vertices = vertices + 0.3 * rng.normal(size=vertices.shape)
    sides = [sorted(side) for side in sides_of(quads)]
    creases = np.array([s for s in sides if rng.random() < share], dtype=np.int64).reshape(-1, 2)
    corners = rng.choice(len(vertices), n_corners, replace=False)
    net = CreasedNet(vertices, quads, creases, corners)
    finer = subdivided(net)
    vertex_point, edge_point, face_point = naive_step(net)

    n, m = len(vertices), len(quads)
    np.testing.assert_allclose(finer.vertices[:n], vertex_point, atol=1e-12)
    np.testing.assert_allclose(finer.vertices[-m:], face_point, atol=1e-12)
    assert len(finer.quads) == 4 * m
    assert len(finer.vertices) == n + len(edge_point) + m
    for child, quad in enumerate(finer.quads.tolist()):
        parent = quads[child // 4].tolist()
        corner = parent[child % 4]
        after, before = parent[(child + 1) % 4], parent[child % 4 - 1]
        assert quad[0] == corner
        assert quad[2] == len(finer.vertices) - m + child // 4
        np.testing.assert_allclose(finer.vertices[quad[1]], edge_point[frozenset((corner, after))])
        np.testing.assert_allclose(finer.vertices[quad[3]], edge_point[frozenset((corner, before))])
    # Every crease goes on as two, except that an open border needs no mark.
    marked = {frozenset(pair) for pair in creases.tolist()}
    inner = [side for side in marked if len(sides_of(quads)[side]) == 2]
    assert len(finer.creases) == 2 * len(inner)
    assert {frozenset(pair) for pair in finer.creases.tolist()} <= set(sides_of(finer.quads))


def test_a_crease_is_the_cubic_spline_of_its_own_vertices(nets):
    vertices, quads = nets.torus(8, 5)
    ring = np.arange(0, 40, 5)  # v = 0, all round the axis
    creases = np.stack([ring, np.roll(ring, -1)], axis=1)
    finer = subdivided(CreasedNet(vertices, quads, creases, np.zeros(0, dtype=int)))
    controls = vertices[ring]
    left, right = np.roll(controls, 1, axis=0), np.roll(controls, -1, axis=0)
    np.testing.assert_allclose(finer.vertices[ring], (left + 6 * controls + right) / 8, atol=1e-12)
    middle = np.setdiff1d(finer.creases.ravel(), ring)
    expected = (controls + right) / 2
    distance = np.linalg.norm(finer.vertices[middle][:, None] - expected[None], axis=2)
    np.testing.assert_allclose(distance.min(axis=1), 0.0, atol=1e-12)


def test_a_cube_with_all_its_edges_sharp_stays_a_cube(nets):
    vertices, quads, _ = nets.box(1)
    creases = np.array([sorted(side) for side in sides_of(quads)])
    net = CreasedNet(vertices, quads, creases, np.zeros(0, dtype=int))
    for _ in range(3):
        net = subdivided(net)
    np.testing.assert_allclose(np.abs(net.vertices).max(axis=1), 1.0)
    np.testing.assert_allclose(net.vertices[:8], vertices)


def test_one_step_of_the_cube_is_the_textbook_one(nets):
    vertices, quads, _ = nets.box(1)
    step = subdivided(CreasedNet(vertices, quads, NONE, np.zeros(0, dtype=int)))
    np.testing.assert_allclose(step.vertices[:8], 5.0 / 9.0 * vertices)
    edge_points = np.sort(np.abs(step.vertices[8:20]), axis=1)
    np.testing.assert_allclose(edge_points, np.tile([0.0, 0.75, 0.75], (12, 1)))
    np.testing.assert_allclose(np.sort(np.abs(step.vertices[20:]), axis=1), [[0.0, 0.0, 1.0]] * 6)
