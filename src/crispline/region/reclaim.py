"""Free forms most of which is on the surface of a neighbour.

A B-spline bends over an edge of which the labels know nothing, and explains the half of a face and
the narrow step beside it as one; the other half of the face, a cylinder, is no surface of both.
But that cylinder goes on over most of the free form, which explains nothing there that the
cylinder does not: it keeps only what is left.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crispline.fit.choose import PRIMITIVE_FITS
from crispline.options import RegionOptions
from crispline.region.borders import Borders
from crispline.region.grow import Ground
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import FREE_FORMS
from crispline.surface.base import Array

_MOST = 0.5  # share of a free form that a neighbour must explain
_KEPT = 0.8  # share of its own patches that it must explain then
_MIN_COSINE = np.cos(np.radians(30.0))  # the net is uneven where pieces of a face meet
_GROWTH_STEPS = 4


def reclaimed(
    label: Labels,
    fits: Mapping[int, RegionFit],
    graph: PatchGraph,
    noise: Array,
    options: RegionOptions,
) -> Labels:
    """Labels after giving neighbours what they explain of free forms that are mostly theirs.

    Parameters
    ----------
    fits : surface of every label.
    noise : of the patch centres, shape ``(m,)``, spacings.
    """
    label = label.copy()
    known = Borders.of(label, graph)
    for free in sorted(fits):
        if fits[free].surface.kind not in FREE_FORMS:
            continue
        members = label == free
        beside = known.regions[(known.regions == free).any(axis=1)].sum(axis=1) - free
        best = np.zeros(0, dtype=np.int64)
        owner = free
        for other in beside.tolist():
            fit = fits.get(other)
            if fit is None or not fit.is_accepted or fit.surface.kind not in PRIMITIVE_FITS:
                continue
            taken = _explained(members, label == other, fit.surface.kind, graph, noise, options)
            if len(taken) > max(len(best), _MOST * members.sum()):
                best, owner = taken, other
        label[best] = owner
    return label


def _explained(
    members: NDArray[np.bool_],
    own: NDArray[np.bool_],
    kind: str,
    graph: PatchGraph,
    noise: Array,
    options: RegionOptions,
) -> Labels:
    """Members of one region that the primitive of another goes on over."""
    both = np.flatnonzero(members | own)
    ground = Ground(
        graph.points[both],
        graph.normals[both],
        csr_array(graph.adjacency[both][:, both]),
        np.ones(len(both), dtype=bool),
        float(np.median(noise[own])),
        _MIN_COSINE,
        _KEPT,
        _GROWTH_STEPS,
    )
    growth = ground.grown(PRIMITIVE_FITS[kind], np.flatnonzero(own[both]))
    if growth is None:
        return np.zeros(0, dtype=np.int64)
    taken = both[growth.patches]
    return np.asarray(taken[members[taken]])
