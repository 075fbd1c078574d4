"""What a reconstruction returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crispline.brep.compose import Solid
from crispline.errors import ReconstructionError
from crispline.exchange.edges import write_edges
from crispline.exchange.models import write_model
from crispline.findings import EdgeReport, FaceReport, corner_vertices, edge_report, faults, numbers
from crispline.gauge.certificate import N_SIGMAS, Certificate, certify, residuals
from crispline.gauge.distance import Deviations, deviations
from crispline.model import Face, Model
from crispline.occt.measure import face_areas, tessellate
from crispline.spline.creased import CreasedNet
from crispline.surface.base import Array

if TYPE_CHECKING:
    from trimesh import Trimesh


@dataclass(frozen=True)
class Reconstruction:
    """A model with what is known about it; lengths in the user's unit.

    Attributes
    ----------
    model : the boundary representation as plain values.
    patches : control net of the sharpened bicubic surface, one patch per quad.
    spacing : mean distance between neighbouring points.
    noise : standard deviation of the points along the surface normal.
    solid : the shape and the evidence for it, or None if none was built.
    certificate : residuals of the whole cloud on the model as written; None without a valid one.
    timings : seconds per stage.
    warnings : sentences for the user.
    patch_kinds : 0 flat, 1 curved, 2 sharp, of every quad of ``patches``; empty if unknown.
    plain_vertices : control points of the plain surface, before ``patches`` was sharpened,
        shape ``(n, 3)``; empty if unknown.
    """

    model: Model
    patches: CreasedNet
    spacing: float
    noise: float
    solid: Solid | None = None
    certificate: Certificate | None = None
    timings: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    patch_kinds: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    plain_vertices: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def valid(self) -> bool:
        """Whether a shape was built that OCCT finds no fault in and that follows the cloud."""
        return self.solid is not None and self.solid.check.is_good

    @property
    def closed(self) -> bool:
        """Whether the shape is a solid without free edges."""
        return self.solid is not None and self.solid.check.is_closed

    @property
    def representation(self) -> str | None:
        """``trimmed``, ``mixed`` or ``patches``, see :class:`Solid`; None if nothing was built."""
        return None if self.solid is None else self.solid.representation

    @property
    def edges(self) -> tuple[EdgeReport, ...]:
        """Every edge, sharp and tangent."""
        return tuple(edge_report(edge, self.spacing) for edge in self.model.edges)

    @property
    def faces(self) -> tuple[FaceReport, ...]:
        """Every face; none of a model of patches only, whose surfaces belong to no region."""
        if self.representation == "patches":
            return ()
        areas = np.full(len(self.model.faces), np.nan)
        if self.solid is not None and -1 not in self.solid.face_order:
            areas[list(self.solid.face_order)] = face_areas(self.solid.shape)
        measured = [residuals(face.residuals, N_SIGMAS * self.noise) for face in self.model.faces]
        if self.solid is not None and self.certificate is not None:
            for index, found in zip(self.solid.face_order, self.certificate.faces, strict=True):
                if index >= 0:
                    measured[index] = found
        return tuple(
            FaceReport(_kind(face), face.surface.parameters(), float(area), **vars(found))
            for face, area, found in zip(self.model.faces, areas, measured, strict=True)
        )

    def certified(self, points: Array, noise: float) -> Reconstruction:
        """The result with the residuals of a cloud; see `crispline.gauge.certificate.certify`.

        Raises
        ------
        ReconstructionError
            If no shape was built.
        """
        mesh = None if self.solid is None else self.solid.mesh
        certificate = certify(self._shape(), points, self.spacing, noise, mesh)
        return replace(self, certificate=certificate)

    @property
    def verdict(self) -> str:
        """How well the model explains the cloud, in words."""
        if self.certificate is None:
            return "not measured: no valid model was built"
        whole, worst = self.certificate.whole, self.certificate.worst_face
        words = (
            f"explains {100.0 * whole.explained:.1f} % of the points within "
            f"{N_SIGMAS:g} sigma ({N_SIGMAS * self.certificate.noise:.3g}); "
            f"p95 {whole.p95:.3g} ({whole.p95 / self.spacing:.2f} spacings)"
        )
        if worst is None:
            return words
        p95 = self.certificate.faces[worst].p95
        return (
            f"{words}; worst {self._face_name(worst)}: p95 {p95:.3g} "
            f"({p95 / self.spacing:.2f} spacings)"
        )

    def require(self, tolerance: float) -> None:
        """Refuse a model with a face whose p95 is above a tolerance, in the user's unit.

        Faces with fewer than ``certificate.MIN_POINTS`` points are not judged.

        Raises
        ------
        ReconstructionError
            A face misses the tolerance, or there is no valid model.
        """
        if self.certificate is None:
            raise ReconstructionError("there is no valid model to hold against a tolerance", self)
        worst = self.certificate.worst_face
        p95 = self.certificate.whole.p95 if worst is None else self.certificate.faces[worst].p95
        if p95 > tolerance:
            where = "the model" if worst is None else self._face_name(worst)
            raise ReconstructionError(
                f"the model is valid, but misses the tolerance of {tolerance:g}: 95 % of the "
                f"points of {where} lie within {p95:.4g} only; scan it with less noise, or allow "
                "more",
                self,
            )

    def _face_name(self, index: int) -> str:
        """A face of the shape in words: its number in the tables if it is one of the model's."""
        owner = -1 if self.solid is None else self.solid.face_order[index]
        if owner < 0:
            return f"patch {index} of the shape"
        return f"face {owner} ({self.model.faces[owner].surface.kind})"

    @property
    def corners(self) -> Array:
        """Points where three sharp edges meet, or two at an angle, shape ``(c, 3)``."""
        return self.model.vertices[corner_vertices(self.model)]

    def deviations(self, points: Array) -> Deviations:
        """Signed distances of points to the model, in the user's unit.

        Parameters
        ----------
        points : shape ``(n, 3)``, for example the cloud.

        Raises
        ------
        ReconstructionError
            If no shape was built.
        """
        shape = self._shape()
        if self.certificate is not None:
            return self.certificate.deviations(points)
        return deviations(shape, points, self.spacing)

    def to_mesh(self, tolerance: float | None = None) -> Trimesh:
        """The model as triangles; ``face_attributes["face"]`` tells which face each is from.

        Parameters
        ----------
        tolerance : largest distance between the model and the triangles, in the user's
            unit; None for a tenth of the spacing.

        Raises
        ------
        ReconstructionError
            If no shape was built.
        """
        from trimesh import Trimesh

        mesh = tessellate(self._shape(), tolerance or 0.1 * self.spacing)
        merged = Trimesh(mesh.vertices, mesh.triangles, process=False)
        merged.face_attributes["face"] = mesh.faces
        merged.merge_vertices()
        return merged

    def _shape(self) -> Any:
        if self.solid is None:
            raise ReconstructionError("there is no model, as no solid was built", self)
        return self.solid.shape

    def write(
        self, path: str | PathLike[str], unit: str = "mm", tolerance: float | None = None
    ) -> None:
        """Write the model whole or not at all; the suffix tells the format.

        STEP, IGES, BREP; GLB, STL, OBJ, PLY triangles: see
        `crispline.exchange.write_model`. DXF and JSON hold the sharp edges: see `write_edges`.

        Parameters
        ----------
        unit : of the cloud's numbers; STEP, IGES, DXF and JSON name it.
        tolerance : largest distance of triangles from the faces; a tenth of the spacing.

        Raises
        ------
        InputError
            Unknown suffix or unit, or the file cannot be written.
        ReconstructionError
            If there is no valid model.
        """
        if not self.valid:
            raise ReconstructionError("there is no valid model to write", self)
        if Path(path).suffix.lower() in (".dxf", ".json"):
            self.write_edges(path, unit)
        else:
            write_model(self, path, unit, tolerance)

    def write_edges(self, path: str | PathLike[str], unit: str = "mm") -> None:
        """Write sharp edges and corners as DXF, JSON, OBJ lines or STEP curves.

        There need be no valid model; see `crispline.exchange.write_edges`.
        """
        sharp = [edge for edge in self.edges if edge.is_sharp]
        write_edges(
            Path(path), sharp, self.corners, spacing=self.spacing, noise=self.noise, unit=unit
        )

    def show(self, points: Array | None = None, **options: Any) -> Any:
        """Open an interactive view; see :func:`crispline.report.show.show`."""
        from crispline.report.show import show

        return show(self, points, **options)

    def _repr_html_(self) -> str:
        """Verdict, numbers and faces, for notebooks."""
        from crispline.report.notebook import notebook_html

        return notebook_html(self)

    def summary(self) -> dict[str, Any]:
        """Everything above in JSON-ready form; unknown numbers are None."""
        faces = [
            {
                "kind": face.kind,
                "parameters": dict(face.parameters),
                "area": None if np.isnan(face.area) else face.area,
                **numbers(face),
            }
            for face in self.faces
        ]
        edges = [
            {
                "kind": edge.kind,
                "length": edge.length,
                "angle_deg": edge.angle_deg,
                "is_sharp": edge.is_sharp,
                "faces": list(edge.faces),
                "gap": edge.gap,
            }
            for edge in self.edges
        ]
        check = None if self.solid is None else self.solid.check
        tolerance = None
        if check is not None:
            tolerance = max(check.edge_tolerance, check.vertex_tolerance)
        return {
            "valid": self.valid,
            "closed": self.closed,
            "representation": self.representation,
            "n_faces": len(faces) if check is None else check.n_faces,
            "n_sharp_edges": sum(edge["is_sharp"] is True for edge in edges),
            "spacing": self.spacing,
            "noise": self.noise,
            "verdict": self.verdict,
            "residuals": None if self.certificate is None else numbers(self.certificate.whole),
            "volume": None if check is None else check.volume,
            "largest_tolerance": tolerance,
            "faces": faces,
            "edges": edges,
            "corners": self.corners.tolist(),
            "timings": dict(self.timings),
            "warnings": list(self.warnings),
        }


def _kind(face: Face) -> str:
    """The kind of surface, or that a face is one of the patches of its region."""
    return "patch" if face.is_patch else face.surface.kind


def failure(result: Reconstruction) -> str:
    """Why a result is no valid model, in one sentence that names the regions."""
    if result.solid is None:
        return "no solid was built"
    return faults(result.model, result.solid.check)
