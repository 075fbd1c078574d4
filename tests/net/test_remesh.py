"""What the mesher returns, made proper."""

import numpy as np

from crispline.net.halfedge import half_edges
from crispline.net.remesh import without_slits


def test_a_quad_that_encloses_nothing_goes_and_leaves_no_hole(nets):
    vertices, quads, _ = nets.box(4)
    a, b, _, c = quads[0]
    proper = without_slits(np.vstack([quads, [[a, b, a, c]]]))
    np.testing.assert_array_equal(proper, quads)
    assert half_edges(proper, len(vertices)).is_closed
