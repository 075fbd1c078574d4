"""Faces to shells, shells to solids with voids."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepLib import BRepLib
from OCP.TopAbs import TopAbs_State
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shell, TopoDS_Solid
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from crispline import occt
from crispline.model import Model


def assemble(model: Model, faces: Mapping[int, Any]) -> tuple[Any, tuple[int, ...]]:
    """Shells of connected faces, and solids of closed shells.

    A closed shell inside an odd number of others is a void of the solid around it;
    every other one is a solid of its own. A shell with a free edge stays a shell.

    Parameters
    ----------
    model : the model.
    faces : for the model's face indices, the built faces; some may be missing.

    Returns
    -------
    shape : the only solid or shell, or a compound of all of them.
    order : model face indices in the exploration order of ``shape``.
    """
    groups = _components(model, faces)
    shells = [_shell([faces[i] for i in group]) for group in groups]
    is_closed = [_is_closed(model, group, faces) for group in groups]
    closed = [i for i in range(len(groups)) if is_closed[i]]
    outward = {i: _outward(shells[i]) for i in closed}
    around = {
        i: [j for j in closed if j != i and _contains(outward[j], model, groups[i])] for i in closed
    }
    parts: list[Any] = []
    order: list[int] = []
    for i in range(len(groups)):
        if not is_closed[i]:
            parts.append(shells[i])
            order += groups[i]
            continue
        if len(around[i]) % 2 == 1:
            continue
        solid = outward[i]
        order += groups[i]
        for j in closed:
            if len(around[j]) == len(around[i]) + 1 and i in around[j]:
                BRep_Builder().Add(solid, occt.subshapes(outward[j], occt.SHELL)[0].Reversed())
                order += groups[j]
        parts.append(solid)
    if len(parts) == 1:
        return parts[0], tuple(order)
    compound = TopoDS_Compound()
    BRep_Builder().MakeCompound(compound)
    for part in parts:
        BRep_Builder().Add(compound, part)
    return compound, tuple(order)


def _components(model: Model, faces: Mapping[int, Any]) -> list[list[int]]:
    """Groups of faces that share edges, each ascending."""
    pairs = [
        (edge.left, edge.right)
        for edge in model.edges
        if edge.left in faces and edge.right in faces
    ]
    rows, columns = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    n = len(model.faces)
    links = coo_array((np.ones(len(pairs)), (rows, columns)), shape=(n, n))
    labels = connected_components(links, directed=False)[1]
    groups: dict[int, list[int]] = {}
    for index in sorted(faces):
        groups.setdefault(int(labels[index]), []).append(index)
    return list(groups.values())


def _is_closed(model: Model, group: list[int], faces: Mapping[int, Any]) -> bool:
    used = {e for i in group for loop in model.faces[i].loops for e, _ in loop}
    return all(model.edges[e].left in faces and model.edges[e].right in faces for e in used)


def _shell(faces: list[Any]) -> Any:
    shell = TopoDS_Shell()
    builder = BRep_Builder()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face)
    return shell


def _outward(shell: Any) -> Any:
    """A solid whose material is inside the shell."""
    shell.Closed(True)
    solid = TopoDS_Solid()
    BRep_Builder().MakeSolid(solid)
    BRep_Builder().Add(solid, shell)
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def _contains(solid: Any, model: Model, group: list[int]) -> bool:
    """Whether a shell lies inside a solid; shells do not meet, so one point tells."""
    face = model.faces[group[0]]
    if face.loops:
        curve = model.edges[face.loops[0][0][0]].curve
        probe = curve.evaluate(np.array([0.5 * (curve.start + curve.end)]))
    else:
        probe = face.surface.project(np.zeros((1, 3)))[0]
    classifier = BRepClass3d_SolidClassifier(solid, occt.point(probe[0]), occt.CONFUSION)
    return bool(classifier.State() == TopAbs_State.TopAbs_IN)
