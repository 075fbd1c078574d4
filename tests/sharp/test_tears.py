"""``locate`` on a thin wall whose net is torn: what the labels show is not what there is."""

import numpy as np
import pytest

from crispline.surface import Cylinder

THICK = 1.8  # of the wall, spacings
BACK, FRONT, TOP = 2, 3, 5


def wall(shapes, raggedness=0.0, seed=0):
    return shapes["box"](raggedness, seed, (40.0, THICK, 20.0))


def tear_top(network, start=15.0, end=22.0, depth=0.0):
    """The top of the wall is missing from ``start`` to ``end``, and of its sides ``depth``."""
    first = network.corner(start, 0.5 * THICK, 20.0)
    last = network.corner(end, 0.5 * THICK, 20.0)
    bottom = np.array([0.5 * (start + end), 0.5 * THICK, 20.0 - depth])
    for side in (BACK, FRONT):
        index = next(k for k, c in enumerate(network.chains) if is_over(network, c, side, start))
        whole = network.chains.pop(index)
        network.truth.pop(index)
        ends = (int(whole.vertices[0]), int(whole.vertices[-1]))
        is_forward = network.vertices[ends[0]][0] < network.vertices[ends[1]][0]
        inner = (first, last) if is_forward else (last, first)
        network.chain(whole.left, whole.right, ends[0], inner[0])
        network.chain(whole.left, whole.right, inner[1], ends[1])
        if side == FRONT:
            # Seen from outside, the front is to the left of its own border with the top ...
            forward = is_forward == (whole.left == FRONT)
    corners = (first, last) if forward else (last, first)
    places = [network.vertices[corner] for corner in corners]

    def along(t):
        sag = bottom[2] * 4.0 * t * (1.0 - t) + 20.0 * (1.0 - 4.0 * t * (1.0 - t))
        straight = places[0] + t[:, None] * (places[1] - places[0])
        return np.column_stack([straight[:, :2], sag])

    network.chain(FRONT, BACK, *corners, curve=along)  # ... and there, to the left of the tear
    return network


def is_over(network, chain, side, place):
    """Whether a chain is the border of a side of the wall with its top, at some x."""
    ends = sorted(network.vertices[vertex][0] for vertex in chain.vertices[[0, -1]])
    return {chain.left, chain.right} == {side, TOP} and ends[0] < place < ends[1]


def pierce(network, radius=1.2):
    """A hole through the wall."""

    def ring(t):
        turn = 2.0 * np.pi * t
        return np.column_stack(
            [30 + radius * np.cos(turn), np.full(t.shape, 0.5 * THICK), 9 + radius * np.sin(turn)]
        )

    network.chain(BACK, FRONT, curve=ring)
    return network


def bridge(network, radius=1.0):
    """A net that runs from the top to the front through the air beside their edge."""

    def ring(t):
        turn = 2.0 * np.pi * t
        across = radius * np.cos(turn) * np.sqrt(0.5)
        return np.column_stack([20.0 + radius * np.sin(turn), -0.4 + across, 20.4 + across])

    network.chain(FRONT, TOP, curve=ring)
    return network


def is_a_box(model):
    counts = (len(model.vertices), len(model.edges), len(model.faces))
    return counts == (8, 12, 6) and all(len(face.loops) == 1 for face in model.faces)


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (0.6, 1), (0.6, 2)])
@pytest.mark.parametrize("depth", [0.0, 4.0])
def test_the_top_goes_on_over_a_tear(shapes, raggedness, seed, depth):
    network = tear_top(wall(shapes, raggedness, seed), depth=depth)
    model, notes = network.located()
    assert is_a_box(model)
    assert model.vertex_gaps.max() < 1e-9
    assert all(edge.curve.kind == "line" for edge in model.edges)
    assert len(notes) == 1
    assert "mended" in notes[0]


def test_a_hole_of_the_net_goes_where_the_points_show_none(shapes):
    network = pierce(wall(shapes))
    x, z = (c.ravel() for c in np.meshgrid(np.arange(26.0, 35.0), np.arange(5.0, 14.0)))
    network.truth += [np.column_stack([x, np.full(x.shape, y), z]) for y in (0.0, THICK)]
    model, notes = network.located()
    assert is_a_box(model)
    assert len(notes) == 1


def test_a_hole_of_the_part_stays(shapes):
    model, _ = pierce(wall(shapes), radius=3.0).located()
    assert sorted(len(face.loops) for face in model.faces) == [1, 1, 1, 1, 2, 2]


def test_a_tear_and_a_hole_go_one_after_the_other(shapes):
    network = pierce(tear_top(tear_top(wall(shapes), 5.0, 9.0), 20.0, 24.0))
    network.truth += [np.array([[30.0, 0.0, 9.0]])]
    model, notes = network.located()
    assert is_a_box(model)
    assert len(notes) == 3


def test_a_long_border_is_no_tear(shapes):
    model, _ = tear_top(wall(shapes), 5.0, 35.0).located()
    assert len(model.edges) == 15


def test_the_edge_of_a_wedge_is_no_tear(shapes):
    # Two faces that lean away from each other and do meet: a roof.
    model, notes = shapes["hip_roof"](0.0, 0, 0.0, 6.0).located()
    assert not any("mended" in note for note in notes)
    assert len(model.faces) == 5


@pytest.mark.parametrize("radius", [0.5, 1.5])
def test_a_bridge_between_faces_that_meet_in_a_line_goes(shapes, radius):
    model, notes = bridge(wall(shapes), radius).located()
    assert is_a_box(model)
    assert len(notes) == 1
    assert "bridged" in notes[0]


@pytest.mark.parametrize("seed", [1, 2])
def test_a_small_bore_is_no_bridge(shapes, seed):
    """Its rims are as small, but its wall and the faces meet in them."""
    network = shapes["box"](0.3, seed)
    radius, bore = 2.0, 6
    centre = np.array([20.0, 15.0, 0.0])
    network.region(bore, Cylinder(centre, np.eye(3)[2], radius), -1)
    for height, left, right in ((0.0, 4, bore), (20.0, bore, 5)):
        around = shapes["ring"](radius, height)
        network.chain(left, right, curve=lambda t, around=around: centre + around(t))
    # The points show no hole in the middle of the rims, as if the bore were filled.
    x, y = (c.ravel() for c in np.meshgrid(np.arange(17.0, 24.0), np.arange(12.0, 19.0)))
    network.truth += [np.column_stack([x, y, np.full(x.shape, z)]) for z in (0.0, 20.0)]
    model, notes = network.located()
    assert not any("bridged" in note for note in notes)
    assert sorted(len(face.loops) for face in model.faces) == [1, 1, 1, 1, 2, 2, 2]
