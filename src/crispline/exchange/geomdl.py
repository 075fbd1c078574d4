"""Surfaces of geomdl (NURBS-Python), as its objects and as the JSON of its `export_json`.

The JSON has the form ``{"shape": {"type": "surface", "count": n, "data": [...]}}``.
Each surface holds ``degree_u``, ``degree_v``, ``knotvector_u``, ``knotvector_v``,
``size_u``, ``size_v`` and ``control_points`` with ``points`` (without weights, v
runs fastest) and, if rational, ``weights``.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crispline.errors import InputError
from crispline.files import write_text
from crispline.spline.checked import checked_spline
from crispline.spline.tensor import TensorSpline


def from_geomdl(surface: Any, where: str = "the geomdl surface") -> TensorSpline:
    """The value of a ``geomdl.BSpline.Surface`` or ``geomdl.NURBS.Surface``; trims are left out.

    Raises
    ------
    InputError
        The surface is not complete, or is no surface.
    """
    try:
        return _spline(
            (surface.degree_u, surface.degree_v),
            (surface.knotvector_u, surface.knotvector_v),
            (surface.ctrlpts_size_u, surface.ctrlpts_size_v),
            surface.ctrlpts,
            surface.weights if surface.rational else None,
            where,
        )
    except AttributeError as error:
        raise InputError(
            f"{where}: expected a surface of geomdl, found {type(surface).__name__} ({error}); "
            "give one surface at a time"
        ) from error


def to_geomdl(spline: TensorSpline) -> Any:
    """The same surface as a ``geomdl.BSpline.Surface``, or ``NURBS.Surface`` if it is rational.

    Knots keep their values. Needs geomdl to be installed.
    """
    from geomdl import NURBS, BSpline

    kind = BSpline if spline.weights is None else NURBS
    surface = kind.Surface(normalize_kv=False)
    surface.degree_u, surface.degree_v = spline.degree_u, spline.degree_v
    net = spline.control_points
    if spline.weights is not None:
        weights = spline.weights[:, :, None]
        net = np.concatenate([net * weights, weights], axis=2)
    surface.set_ctrlpts(net.reshape(-1, net.shape[2]).tolist(), *net.shape[:2])
    surface.knotvector_u, surface.knotvector_v = spline.knots_u.tolist(), spline.knots_v.tolist()
    return surface


def read_json(path: Path) -> tuple[tuple[TensorSpline, ...], int]:
    """The surfaces in a JSON file of geomdl, and how many have trims, which are left out.

    Raises
    ------
    InputError
        Not such a file, or it holds something else than surfaces.
    """
    try:
        shape = json.loads(path.read_text(encoding="utf-8"))["shape"]
        kind, data = shape["type"], shape["data"]
    except (ValueError, TypeError, KeyError) as error:
        raise InputError(
            f"'{path}': expected surfaces as geomdl's export_json writes them, found content "
            f"that cannot be read as such ({error}); check that the file is complete"
        ) from error
    if kind != "surface" or not data:
        raise InputError(
            f"'{path}': expected surfaces as geomdl's export_json writes them, found "
            f"{len(data)} of type '{kind}'; export the surface itself"
        )
    splines = tuple(
        _from_record(record, f"'{path}', surface {i}") for i, record in enumerate(data, 1)
    )
    return splines, sum(bool(record.get("trims")) for record in data)


def _from_record(record: Any, where: str) -> TensorSpline:
    try:
        net = record["control_points"]
        return _spline(
            (record["degree_u"], record["degree_v"]),
            (record["knotvector_u"], record["knotvector_v"]),
            (record["size_u"], record["size_v"]),
            net["points"],
            net.get("weights"),
            where,
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"{where}: expected degree, knotvector, size and control_points, found a record "
            f"without them ({error}); export it with geomdl's export_json"
        ) from error


def _spline(
    degrees: tuple[int, int],
    knots: tuple[ArrayLike, ArrayLike],
    sizes: tuple[int, int],
    points: Sequence[Sequence[float]],
    weights: Sequence[float] | None,
    where: str,
) -> TensorSpline:
    n_u, n_v = sizes
    if len(points) != n_u * n_v:
        raise InputError(
            f"{where}: expected {n_u} x {n_v} = {n_u * n_v} control points, found {len(points)}; "
            "export the surface again"
        )
    if weights is not None and len(weights) != len(points):
        raise InputError(
            f"{where}: expected one weight for each of {len(points)} control points, found "
            f"{len(weights)}; export the surface again"
        )
    rows = [slice(i * n_v, (i + 1) * n_v) for i in range(n_u)]
    return checked_spline(
        degrees[0],
        degrees[1],
        knots[0],
        knots[1],
        [points[row] for row in rows],
        None if weights is None else [weights[row] for row in rows],
        where,
    )


def write_json(path: Path, splines: Sequence[TensorSpline]) -> None:
    """Write surfaces so that geomdl's ``import_json`` reads them; every digit is kept."""
    shape = {"type": "surface", "count": len(splines), "data": [_record(s) for s in splines]}
    write_text(path, json.dumps({"shape": shape}, indent=1, allow_nan=False) + "\n")


def _record(spline: TensorSpline) -> dict[str, Any]:
    n_u, n_v, dimension = spline.control_points.shape
    net: dict[str, Any] = {"points": spline.control_points.reshape(-1, dimension).tolist()}
    if spline.weights is not None:
        net["weights"] = spline.weights.ravel().tolist()
    return {
        "type": "spline",
        "rational": spline.weights is not None,
        "dimension": dimension,
        "degree_u": spline.degree_u,
        "degree_v": spline.degree_v,
        "knotvector_u": spline.knots_u.tolist(),
        "knotvector_v": spline.knots_v.tolist(),
        "size_u": n_u,
        "size_v": n_v,
        "control_points": net,
    }
