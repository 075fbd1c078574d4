"""Cuts along several edges of one face tell of each other."""

from dataclasses import replace

import numpy as np
from broken_edge import EDGE, SIDE, TOP, broken_edge

from crispline.options import RegionOptions
from crispline.region.narrow.cut import asked_cut, cuts_round_one_face
from crispline.region.narrow.stretch import stretches
from crispline.surface import Plane

X, _, Z = np.eye(3)
OPTIONS = RegionOptions()


def two_cuts(setbacks):
    """What a cutter has left along two edges of the top, the second no sure chamfer."""
    cuts = []
    for other, legs in ((SIDE, setbacks[0]), (SIDE + 10, setbacks[1])):
        made, label, _ = broken_edge([(EDGE - legs[0], 0.0), (EDGE, -legs[1])], True)
        fits = made.fits({TOP: Plane(np.zeros(3), Z), SIDE: Plane(EDGE * X, X)}, label)
        (edge,) = stretches(label, fits, {}, made.evidence, OPTIONS)
        cut = asked_cut(edge, OPTIONS)
        assert cut.is_sure
        cuts.append(replace(cut, edge=replace(edge, faces=(TOP, other)), is_sure=other == SIDE))
    return cuts


def groups(cuts):
    return [[cut.edge.faces for cut in group] for group in cuts_round_one_face(cuts)]


def test_what_is_no_sure_chamfer_is_one_if_the_cutter_that_went_on_there_left_it():
    alike = two_cuts([(2.0, 2.0), (2.0, 2.0)])
    assert groups(alike) == [[(TOP, SIDE), (TOP, SIDE + 10)]]
    assert groups(alike[1:]) == []
    assert groups(two_cuts([(2.0, 2.0), (4.0, 3.0)])) == [[(TOP, SIDE)]]
