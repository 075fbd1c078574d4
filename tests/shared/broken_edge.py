"""An edge of two known faces that is broken by a round or a chamfer, or sharp."""

import numpy as np
from turned import turned

TOP, SIDE = 0, 1
EDGE, N_AROUND = 16.2, 60


def broken_edge(breaking, is_straight, turn=-1.0, n_around=N_AROUND):
    """A top whose rim is broken as given, and a side that goes down from it, or up.

    Returns
    -------
    The part, labels of its patches as if the two faces had closed over the break, and which of
    the patches are on it.
    """
    corners = [(3.0, 0.0), *breaking, (EDGE, turn * 9.0)]
    made = turned(corners, n_around, is_straight)
    points = made.evidence.graph.points
    reach = points[:, 0] if is_straight else np.hypot(points[:, 0], points[:, 1])
    label = np.where(EDGE - reach > np.abs(points[:, 2]), TOP, SIDE)  # they meet halfway
    is_broken = (made.face > 0) & (made.face < made.face.max())
    return made, label, is_broken


def arc(radius, n_pieces=5, turn=-1.0):
    """The corners of a round of the edge."""
    turns = np.linspace(0.0, 0.5 * np.pi, n_pieces + 1)
    inner = EDGE - radius
    return [(inner + radius * np.sin(t), turn * radius * (1.0 - np.cos(t))) for t in turns]
