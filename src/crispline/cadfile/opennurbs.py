"""A trimmed solid in the archive format of openNURBS, which 3DM files are made of.

The packages that write 3DM files build boxes and meshes, but no solid of trimmed
faces; they decode one from this archive, and check it. Here are its tables and their
bytes, without OCCT; `crispline.cadfile.rhino` fills them.

References
----------
openNURBS toolkit, ``ON_Brep``, ``ON_NurbsCurve``, ``ON_NurbsSurface`` and
``ON_BinaryArchive``; integers of 4 bytes, little endian, chunk lengths of 8.
"""

from __future__ import annotations

import struct
import uuid
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from crispline.surface.base import Array

_ANONYMOUS, _CLASS, _CLASS_UUID = 0x40008000, 0x00027FFA, 0x0002FFFB
_CLASS_DATA, _CLASS_END = 0x0002FFFC, 0x80027FFF
_HAS_CRC = 0x8000
_CURVE = uuid.UUID("4ED7D4DD-E947-11d3-BFE5-0010830122F0")
_SURFACE = uuid.UUID("4ED7D4DE-E947-11d3-BFE5-0010830122F0")
_BREP = uuid.UUID("60B5DBC5-E660-11d3-BFE4-0010830122F0")
_FACE_IDS = uuid.UUID("c7c1a35e-3b0e-4a8f-9d7a-0d7f3a6e5b11")


class TrimKind(IntEnum):
    """How a side of a face borders."""

    BOUNDARY = 1
    MATED = 2
    SEAM = 3
    SINGULAR = 4


class Iso(IntEnum):
    """Which parameter is constant along a trim, and whether at an end of its range."""

    NONE = 0
    U = 1
    V = 2
    WEST = 3
    SOUTH = 4
    EAST = 5
    NORTH = 6


@dataclass(frozen=True)
class Nurbs:
    """A curve or a surface.

    Attributes
    ----------
    degrees : one for a curve, two for a surface.
    knots : one array a degree, clamped or not; ``n + degree + 1`` of them.
    control_points : shape ``(n, dim)`` or ``(n_u, n_v, 3)``.
    weights : shape ``(n,)`` or ``(n_u, n_v)``, or None.
    """

    degrees: tuple[int, ...]
    knots: tuple[Array, ...]
    control_points: Array
    weights: Array | None

    @property
    def domains(self) -> tuple[tuple[float, float], ...]:
        """Range of each parameter."""
        return tuple(
            (float(knots[degree]), float(knots[-degree - 1]))
            for knots, degree in zip(self.knots, self.degrees, strict=True)
        )


@dataclass(frozen=True)
class Vertex:
    """A point and the edges that end there, twice if both ends do."""

    point: tuple[float, float, float]
    tolerance: float
    edges: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Edge:
    """A curve from one vertex to another, and the trims that run along it."""

    curve: Nurbs
    start: int
    end: int
    tolerance: float
    trims: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Trim:
    """A curve in the parameter plane of a face; ``edge`` is -1 at a pole."""

    curve: Nurbs
    edge: int
    start: int
    end: int
    is_reversed: bool
    kind: TrimKind
    iso: Iso
    loop: int


@dataclass(frozen=True)
class Loop:
    """Trims in order, with the face on their left in the parameter plane."""

    trims: tuple[int, ...]
    is_outer: bool
    face: int


@dataclass(frozen=True)
class Face:
    """A surface and its loops, the outer one first."""

    surface: Nurbs
    loops: tuple[int, ...]
    is_reversed: bool


@dataclass(frozen=True)
class Brep:
    """The tables of a solid or a shell; all references are places in them."""

    vertices: Sequence[Vertex]
    edges: Sequence[Edge]
    trims: Sequence[Trim]
    loops: Sequence[Loop]
    faces: Sequence[Face]
    is_solid: bool


class _Chunk(bytes):
    """A finished chunk, which the checksum of the one round it leaves out."""


def encode(brep: Brep) -> bytes:
    """The archive of a solid: what ``rhino3dm.CommonObject.Decode`` takes as data."""
    points = np.array([vertex.point for vertex in brep.vertices])
    no_meshes = _chunk(_ANONYMOUS, bytes(len(brep.faces)))
    return _object(
        _BREP,
        b"\x32",
        _objects([_nurbs(trim.curve) for trim in brep.trims]),
        _objects([_nurbs(edge.curve) for edge in brep.edges]),
        _objects([_nurbs(face.surface) for face in brep.faces]),
        _table([_vertex(i, vertex) for i, vertex in enumerate(brep.vertices)]),
        _table([_edge(i, edge) for i, edge in enumerate(brep.edges)]),
        _table([_trim(i, trim) for i, trim in enumerate(brep.trims)]),
        _table([_loop(i, loop) for i, loop in enumerate(brep.loops)]),
        _table(
            [_face(i, face) for i, face in enumerate(brep.faces)],
            b"\x11",
            [uuid.uuid5(_FACE_IDS, str(i)).bytes_le for i in range(len(brep.faces))],
        ),
        _doubles(points.min(axis=0)),
        _doubles(points.max(axis=0)),
        no_meshes,  # for display
        no_meshes,  # for analysis
        _ints(1 if brep.is_solid else 0),
    )


def _vertex(index: int, vertex: Vertex) -> bytes:
    return (
        _ints(index) + _doubles(vertex.point) + _list(vertex.edges) + _doubles([vertex.tolerance])
    )


def _edge(index: int, edge: Edge) -> bytes:
    domain = _doubles(edge.curve.domains[0])
    return (
        _ints(index, index, 0)
        + domain
        + _ints(edge.start, edge.end)
        + _list(edge.trims)
        + _doubles([edge.tolerance])
        + domain
    )


def _trim(index: int, trim: Trim) -> bytes:
    domain, no_tolerance = _doubles(trim.curve.domains[0]), _doubles([0.0, 0.0])
    return (
        _ints(index, index)
        + domain
        + _ints(trim.edge, trim.start, trim.end, trim.is_reversed, trim.kind, trim.iso, trim.loop)
        + no_tolerance
        + domain
        + bytes(32)
        + no_tolerance
    )


def _loop(index: int, loop: Loop) -> bytes:
    return _ints(index) + _list(loop.trims) + _ints(1 if loop.is_outer else 2, loop.face)


def _face(index: int, face: Face) -> bytes:
    return _ints(index) + _list(face.loops) + _ints(index, face.is_reversed, 0)


def _nurbs(item: Nurbs) -> _Chunk:
    """Knots without the first and last of each vector; control points times their weights."""
    is_rational, is_surface = item.weights is not None, len(item.degrees) == 2
    control_points = item.control_points
    dimension = control_points.shape[-1]
    if item.weights is not None:
        weights = item.weights[..., None]
        control_points = np.concatenate([control_points * weights, weights], axis=-1)
    counts = control_points.shape[:-1]
    orders = [degree + 1 for degree in item.degrees]
    parts = [b"\x10", _ints(dimension, is_rational, *orders, *counts, 0, 0), bytes(48)]
    for knots in item.knots:
        parts += [_ints(len(knots) - 2), _doubles(knots[1:-1])]
    parts += [_ints(int(np.prod(counts))), _doubles(control_points)]
    return _object(_SURFACE if is_surface else _CURVE, *parts)


def _table(rows: Sequence[bytes], version: bytes = b"\x10", tail: Sequence[bytes] = ()) -> _Chunk:
    return _chunk(_ANONYMOUS, version, _ints(len(rows)), *rows, *tail)


def _objects(items: Sequence[_Chunk]) -> _Chunk:
    parts = [part for item in items for part in (_ints(1), item)]
    return _chunk(_ANONYMOUS, b"\x10", _ints(len(items)), *parts)


def _object(kind: uuid.UUID, *parts: bytes) -> _Chunk:
    end = _Chunk(struct.pack("<Iq", _CLASS_END, 0))
    return _chunk(_CLASS, _chunk(_CLASS_UUID, kind.bytes_le), _chunk(_CLASS_DATA, *parts), end)


def _chunk(code: int, *parts: bytes) -> _Chunk:
    body = b"".join(parts)
    if code & _HAS_CRC:
        own = b"".join(part for part in parts if not isinstance(part, _Chunk))
        body += struct.pack("<I", zlib.crc32(own))
    return _Chunk(struct.pack("<Iq", code, len(body)) + body)


def _ints(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}i", *values)


def _list(values: Sequence[int]) -> bytes:
    return _ints(len(values), *values)


def _doubles(values: Sequence[float] | Array) -> bytes:
    return np.ascontiguousarray(values, dtype="<f8").tobytes()
