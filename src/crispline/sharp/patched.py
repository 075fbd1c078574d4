"""Regions as bicubic patches inside a trimmed model.

Where a region has no surface whose borders can be trimmed, the quads of the net under it
are faces themselves: few B-spline surfaces that share their borders, exactly, with each
other, and, within a gap that is measured, with the trimmed faces around.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.model import Edge, Face, Model
from crispline.net.quads import QuadNet
from crispline.region.patches import Labels
from crispline.region.topology import Chain, Topology
from crispline.sharp.preserve import N_SAMPLES, corners_of, placed_on, reach, sides_of
from crispline.spline.bezier import corner_points
from crispline.spline.creased import CreasedNet, Index
from crispline.spline.quilt import Quilt, QuiltEdge, quilt
from crispline.spline.relax import relaxed
from crispline.spline.separate import separated
from crispline.spline.through import passing_through
from crispline.surface.base import Array

_GAP_SAMPLES = 33
_RELAXED_RINGS = 3


@dataclass(frozen=True)
class LabelledNet:
    """What a model was located on.

    Attributes
    ----------
    net : in the frame of the model.
    label : region of every quad, shape ``(m,)``.
    topology : its borders; chains stand in the order of the model's edges.
    """

    net: QuadNet
    label: Labels
    topology: Topology


def patched(
    model: Model, source: LabelledNet, regions: Collection[int], max_move: float
) -> Model | None:
    """The model with the faces of some regions replaced by patches.

    Parameters
    ----------
    model : trimmed faces in a frame where the spacing is 1.
    source : what it was located on.
    regions : labels of the faces to replace.
    max_move : a border or corner that lies farther than this from the net keeps to the net; a
        corner not if a border of two trimmed faces ends there.

    Returns
    -------
    Faces that stay come first, in their order; the patches have the label of their region and
    no points. None where the borders of the regions are no sides of the net (they were
    contracted), or the patches cannot be laid out.
    """
    if not has_sides(source, regions):
        return None
    inside = [(c.left in regions, c.right in regions) for c in source.topology.chains]
    try:
        net, origin = _subnet(model, source, inside, np.isin(source.label, list(regions)), max_move)
        net = passing_through(separated(net))
        cover = quilt(net)
    except InputError:
        return None
    return _Weaver(model, source, frozenset(regions), inside, net, origin, cover).woven()


def has_sides(source: LabelledNet, regions: Collection[int]) -> bool:
    """Whether the borders of some regions are sides of the net: none beside them collapsed."""
    beside = [
        _pairs(chain)
        for chain in source.topology.chains
        if chain.left in regions or chain.right in regions
    ]
    pairs = np.concatenate([np.zeros((0, 2), dtype=np.int64), *beside])
    return len(sides_of(source.net.quads, pairs)) == len(pairs)


def _pairs(chain: Chain) -> Index:
    return np.stack([chain.vertices[:-1], chain.vertices[1:]], axis=1)


def _subnet(
    model: Model,
    source: LabelledNet,
    inside: list[tuple[bool, bool]],
    is_chosen: NDArray[np.bool_],
    max_move: float,
) -> tuple[CreasedNet, Index]:
    """The net under the regions, on the located borders where these are near, and the
    vertices of the whole net that its vertices are.
    """
    vertices = source.net.vertices.copy()
    is_placed = np.zeros(len(vertices), dtype=bool)
    creases = [np.zeros((0, 2), dtype=np.int64)]
    ends: list[int] = []
    trimmed = [edge for edge, sides in zip(model.edges, inside, strict=True) if not any(sides)]
    is_held = np.zeros(len(model.vertices), dtype=bool)
    is_held[[end for edge in trimmed for end in (edge.start, edge.end)]] = True
    for chain, edge, (left, right) in zip(source.topology.chains, model.edges, inside, strict=True):
        if not (left or right):
            continue
        chosen, curve = source.net.vertices[chain.vertices], edge.curve.samples(N_SAMPLES)
        is_near = reach(chosen, curve) <= max_move
        is_placed[chain.vertices] = True
        if is_near:
            vertices[chain.vertices] = placed_on(chosen, curve)
        if left != right:
            ends += chain.vertices[[0, -1]].tolist()
        elif edge.is_sharp and is_near:
            creases.append(_pairs(chain))
        if not chain.is_closed:
            ends_at = chain.vertices[[0, -1]]
            corners = model.vertices[[edge.start, edge.end]]
            is_far = np.linalg.norm(corners - source.net.vertices[ends_at], axis=1) > max_move
            # A corner that was located badly binds trimmed edges only.
            moves = ~is_far | is_held[[edge.start, edge.end]]
            vertices[ends_at[moves]] = corners[moves]
    origin, quads = np.unique(source.net.quads[is_chosen], return_inverse=True)
    number = np.full(len(vertices), -1)
    number[origin] = np.arange(len(origin))
    kept = number[np.concatenate(creases)]
    tagged = np.union1d(number[np.array(ends, dtype=np.int64)], corners_of(kept, len(origin)))
    net = CreasedNet(vertices[origin], quads.reshape(-1, 4), kept, tagged)
    return relaxed(net, np.flatnonzero(is_placed[origin]), _RELAXED_RINGS), origin


@dataclass(frozen=True)
class _Weaver:
    """Puts the patches into the model."""

    model: Model
    source: LabelledNet
    regions: frozenset[int]
    inside: list[tuple[bool, bool]]
    net: CreasedNet
    origin: Index
    cover: Quilt

    def woven(self) -> Model | None:
        """The model, or None if a border of the patches is no run of a chain."""
        stays = [i for i, face in enumerate(self.model.faces) if face.region not in self.regions]
        number = {-1: -1} | {old: new for new, old in enumerate(stays)}
        n_kept = len(stays)
        at = self._net_vertices()
        vertex, added = self._model_vertices(at)
        rims = {
            (int(at[edge.start]), int(at[edge.end])): index
            for index, edge in enumerate(self.cover.edges)
            if edge.right is None
        }
        edges: list[Edge] = []
        runs: list[list[tuple[int, int]]] = []  # the new edges of every old one, along its curve
        place: dict[int, int] = {}  # the new edge that each edge of the cover is
        is_seen = np.zeros(len(self.net.vertices), dtype=bool)
        is_seen[at] = True
        for chain, edge, (left, right) in zip(
            self.source.topology.chains, self.model.edges, self.inside, strict=True
        ):
            if left and right:
                runs.append([])
                continue
            if not (left or right):
                runs.append([(len(edges), 1)])
                edges.append(replace(edge, left=number[edge.left], right=number[edge.right]))
                continue
            sign = 1 if left else -1
            found = self._run(chain.vertices[::sign], rims, is_seen)
            if found is None:
                return None
            run = []
            for index in found:
                run.append((len(edges), sign))
                place[index] = len(edges)
                other = edge.right if left else edge.left
                edges.append(
                    self._rim(self.cover.edges[index], edge, other, number, n_kept, vertex)
                )
            runs.append(run[::sign])
        for index, seam in enumerate(self.cover.edges):
            if index in place:
                continue
            if seam.right is None:
                return None
            place[index] = len(edges)
            edges.append(
                Edge(
                    seam.curve, vertex[seam.start], vertex[seam.end],
                    n_kept + seam.left.face, n_kept + seam.right.face, 0.0, 0.0, seam.is_sharp,
                )
            )  # fmt: skip
        faces = [
            replace(self.model.faces[i], loops=_rerouted(self.model.faces[i], runs)) for i in stays
        ]
        faces += self._patches(place)
        vertices = np.concatenate([self.model.vertices, added])
        vertices[vertex] = self.cover.vertices
        gaps = np.concatenate([self.model.vertex_gaps, np.zeros(len(added))])
        # Patches go through the vertices: of their gaps only those to trimmed faces are left.
        gaps = np.where(
            np.isin(np.arange(len(gaps)), vertex), _gaps(vertices, edges, faces[:n_kept]), gaps
        )
        return Model(vertices, gaps, tuple(edges), tuple(faces))

    def _net_vertices(self) -> Index:
        """The vertex of the net that each vertex of the cover is."""
        position = corner_points(self.net).position
        order = {row.tobytes(): index for index, row in reversed(list(enumerate(position)))}
        return np.array([order[row.tobytes()] for row in self.cover.vertices], dtype=np.int64)

    def _model_vertices(self, at: Index) -> tuple[list[int], Array]:
        """The model's vertex for each of the cover, and the positions of those it has not yet."""
        known: dict[int, int] = {}
        for chain, edge in zip(self.source.topology.chains, self.model.edges, strict=True):
            if not chain.is_closed:
                known |= {int(chain.vertices[0]): edge.start, int(chain.vertices[-1]): edge.end}
        known_at = [known.get(int(self.origin[v]), -1) if v < len(self.origin) else -1 for v in at]
        fresh = np.flatnonzero(np.array(known_at) < 0)
        vertex = list(known_at)
        for new, index in enumerate(fresh.tolist()):
            vertex[index] = len(self.model.vertices) + new
        return vertex, self.cover.vertices[fresh]

    def _run(
        self, vertices: Index, rims: dict[tuple[int, int], int], is_seen: NDArray[np.bool_]
    ) -> list[int] | None:
        """The border edges of the cover along a chain of the whole net."""
        local = np.searchsorted(self.origin, vertices)
        stops = local[is_seen[local]].tolist()
        if len(stops) < 2:
            return None
        found = [rims.pop(pair, -1) for pair in itertools.pairwise(stops)]
        return None if -1 in found else found

    def _rim(
        self,
        seam: QuiltEdge,
        edge: Edge,
        other: int,
        number: dict[int, int],
        n_kept: int,
        vertex: list[int],
    ) -> Edge:
        gap = 0.0
        if other >= 0:
            samples = seam.curve.samples(_GAP_SAMPLES)
            foot = self.model.faces[other].surface.project(samples)[0]
            gap = float(np.linalg.norm(foot - samples, axis=1).max())
        start, end, left = vertex[seam.start], vertex[seam.end], n_kept + seam.left.face
        return Edge(seam.curve, start, end, left, number[other], gap, edge.angle, edge.is_sharp)

    def _patches(self, place: dict[int, int]) -> list[Face]:
        """The faces of the cover."""
        borders: list[list[tuple[float, int, int]]] = [[] for _ in self.cover.faces]
        for index, seam in enumerate(self.cover.edges):
            for side, sign in ((seam.left, 1), (seam.right, -1)):
                if side is not None:
                    borders[side.face].append((side.place, place[index], sign))
        first = np.unique(self.cover.face_of_quad, return_index=True)[1]
        region = self.source.label[np.isin(self.source.label, list(self.regions))][first]
        return [
            Face(
                surface,
                1,
                (tuple((edge, sign) for _, edge, sign in sorted(border)),),
                np.zeros((0, 3)),
                np.zeros(0),
                int(label),
                is_patch=True,
            )
            for surface, border, label in zip(self.cover.faces, borders, region, strict=True)
        ]


def _gaps(vertices: Array, edges: Sequence[Edge], faces: Sequence[Face]) -> Array:
    """Largest distance of every vertex to those of some faces that meet there, shape ``(n,)``."""
    gaps = np.zeros(len(vertices))
    for face in faces:
        around = np.unique(
            [end for loop in face.loops for e, _ in loop for end in (edges[e].start, edges[e].end)]
        )
        if len(around):
            away = np.abs(face.surface.signed_distance(vertices[around]))
            gaps[around] = np.maximum(gaps[around], away)
    return gaps


def _rerouted(
    face: Face, runs: list[list[tuple[int, int]]]
) -> tuple[tuple[tuple[int, int], ...], ...]:
    """The loops of a face over the new edges."""
    return tuple(
        tuple(
            (new, sign * turn)
            for edge, sign in loop
            for new, turn in (runs[edge] if sign > 0 else runs[edge][::-1])
        )
        for loop in face.loops
    )
