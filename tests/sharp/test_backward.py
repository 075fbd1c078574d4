"""Short borders that the net has across, or backward: what leads away from their corners tells."""

import numpy as np
import pytest


def ridge_turned(shapes, mismatch, turn):
    """A hip roof whose ridge the net has in another direction than labels would have it."""
    network = shapes["hip_roof"](0.0, 0, mismatch)
    heading = 0.5 * np.array([np.cos(turn), np.sin(turn), 0.0])
    network.vertices[4] = [0.0, 0.0, 8.0] - heading
    network.vertices[5] = np.array([0.0, 0.0, 8.0]) + heading
    network.vertices[-1] = [0.0, 0.0, 8.0]
    return network


def assert_ridge(network, ridge):
    model, warnings = network.located()
    assert warnings == ()
    assert len(model.edges) == 9
    assert ridge in [{edge.left, edge.right} for edge in model.edges]
    assert model.vertex_gaps.max() < 1e-9


@pytest.mark.parametrize("turn", np.radians([0.0, 60.0, 95.0, 130.0, 180.0, 250.0, 300.0]))
def test_a_ridge_stays_whichever_way_the_net_has_it(shapes, turn):
    assert_ridge(ridge_turned(shapes, 0.6, turn), {0, 2})


@pytest.mark.parametrize("turn", np.radians([-60.0, 0.0, 60.0]))
def test_a_ridge_that_runs_the_other_way_is_backward(shapes, turn):
    assert_ridge(ridge_turned(shapes, -0.6, turn), {1, 3})
