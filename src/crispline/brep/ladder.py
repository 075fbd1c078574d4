"""The best model that stands: trimmed faces, patches where a region fails, patches only."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from crispline import occt
from crispline.brep.compose import Solid, make_solid
from crispline.brep.patchsolid import patch_solid
from crispline.errors import ReconstructionError
from crispline.model import Model
from crispline.sharp.locate import Located
from crispline.sharp.patched import LabelledNet, has_sides, patched
from crispline.spline.creased import CreasedNet
from crispline.surface.base import Array, Similarity

_REFUSALS: tuple[type[Exception], ...] = (ReconstructionError, *occt.FAILURES)
_BARE = 2.0
"""Vertices of the net farther than this from every point span a hole, in spacings."""
_MAX_ROUNDS = 3
"""How often regions that turn out to fail beside patches become patches too."""
_OPEN = 0.3
"""Gap that a model may have that does without a narrow region, in spacings; or as it was before."""
_MAX_SHARE = 0.35
"""Share of the quads above which a model of patches only is simpler ..."""
_MAX_PATCHES = 1000
"""... and number of patches, as each is built and meshed like any other face."""

_NO_FACES = (
    "no surfaces explain most of the scan, so the model is made of bicubic patches only; if the "
    "part has plain faces, the scan is too noisy or too coarse for them, or bent"
)
_EXPLAINED = "which explain its points as well"
_BESIDE = "a face beside it fails"
_NARROW = "though they do not explain its points, being a few spacings wide (scan it more densely)"
_ROUNDED = (
    "patches that follow the located edges are not valid, so the patches are smooth everywhere "
    "and round off the edges"
)


@dataclass(frozen=True)
class Attempt:
    """A model in the user's unit, the shape of it, and what the user should know.

    Attributes
    ----------
    model : of a shape of patches only, the trimmed model that failed.
    solid : None if no shape could be built at all.
    warnings : which regions are patches, and why.
    """

    model: Model
    solid: Solid | None
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class Ladder:
    """What every rung is built from.

    Attributes
    ----------
    model : trimmed faces, in the frame where the spacing is 1.
    source : what the model was located on.
    net : the sharpened bicubic surface, in that frame.
    plain : vertices of the net before any was moved, shape ``(n, 3)``.
    to_user : from that frame to the user's unit.
    points : the cloud without outliers in the user's unit, shape ``(n, 3)``.
    max_move : see :func:`crispline.sharp.patched.patched`.
    has_faces : whether the surfaces of the model explain the cloud. Where they do not,
        trimming them is a waste of time, and patches come first.
    doubts : what the surfaces leave open, in words.
    located_beside : the same model located anew, with no border collapsed beside the regions of
        some labels, which become patches.
    without : the ladder of a model without those regions of some labels that their neighbours
        explain as well; None if there are none.
    without_narrow : the same without those that are only a few spacings wide.
    """

    model: Model
    source: LabelledNet
    net: CreasedNet
    plain: Array
    to_user: Similarity
    points: Array
    max_move: float
    has_faces: bool
    doubts: tuple[str, ...]
    located_beside: Callable[[Collection[int]], Located]
    without: Callable[[Collection[int]], Ladder | None]
    without_narrow: Callable[[Collection[int]], Ladder | None]

    @property
    def spacing(self) -> float:
        """Of the points, in the user's unit."""
        return self.to_user.scale

    @cached_property
    def _places(self) -> Array:
        """Where a model must be and may be: the points, and the net over the holes it fills."""
        net = np.concatenate([self.source.net.vertices, self.plain])
        distance = cKDTree(self.to_user.inverse().points(self.points)).query(net)[0]
        return np.concatenate([self.points, self.to_user.points(net[distance > _BARE])])

    def climb(self, kind: Literal["auto", "trimmed", "patches"]) -> Attempt:
        """The first rung that holds, or the one with the fewest faults, see `Solid.check`.

        Parameters
        ----------
        kind : ``auto`` goes from trimmed faces to patches; the others try one rung only.
        """
        model = self.model.transformed(self.to_user)
        if kind == "patches":
            return self._attempt(model, *self._patches())
        patches: tuple[Solid | None, tuple[str, ...]] | None = None
        if kind == "auto" and not self.has_faces:
            patches = self._patches()
            if _is_good(patches[0]):
                return self._attempt(model, patches[0], (_NO_FACES, *patches[1]))
        trimmed = self._trimmed()
        if _is_good(trimmed.solid):
            return trimmed
        reasons = _reasons(self.model, trimmed.solid) if trimmed.solid is not None else {}
        fewer = self.without(reasons) if reasons else None
        if fewer is not None:
            again = fewer.climb(kind)
            warnings = self._given_up(reasons, fewer, _EXPLAINED)
            return replace(again, warnings=warnings + again.warnings)
        # What spoils a face may be a crumb beside it, which is none the worse.
        fewer = self.without(self._at(reasons)) if reasons else None
        if fewer is not None and _gap(fewer.model) <= max(_gap(self.model), _OPEN):
            again = fewer._trimmed()
            if _is_good(again.solid):
                warnings = self._given_up(reasons, fewer, _EXPLAINED)
                return replace(again, warnings=warnings + again.warnings)
        # Rather a solid without a groove of two spacings, and said so, than patches instead.
        fewer = self.without_narrow(reasons) if reasons else None
        if fewer is not None and _gap(fewer.model) <= max(_gap(self.model), _OPEN):
            again = fewer.climb("trimmed")
            if _is_good(again.solid):
                warnings = self._given_up(reasons, fewer, _NARROW)
                return replace(again, warnings=warnings + again.warnings)
        if kind == "trimmed":
            return trimmed
        if trimmed.solid is not None:
            mixed = self._mixed(trimmed.solid)
            if mixed is not None:
                return mixed
        solid, warnings = patches or self._patches()
        if _is_good(solid):
            reason = "no trimmed model is valid, so the model is made of bicubic patches only"
            return self._attempt(model, solid, (reason, *warnings))
        return trimmed

    def _trimmed(self) -> Attempt:
        model = self.model.transformed(self.to_user)
        return self._attempt(model, *_tried(lambda: make_solid(model, self._places, self.spacing)))

    def _patches(self) -> tuple[Solid | None, tuple[str, ...]]:
        """Patches with the located edges; without, where moving the net to them spoils it."""
        net = replace(self.net, vertices=self.to_user.points(self.net.vertices))
        solid, warnings = _tried(lambda: patch_solid(net, self._places, self.spacing))
        if _is_good(solid):
            return solid, warnings
        none = np.zeros((0, 2), dtype=np.int64)
        smooth = CreasedNet(self.to_user.points(self.plain), self.net.quads, none, none[:, 0])
        rounded, _ = _tried(lambda: patch_solid(smooth, self._places, self.spacing))
        return (rounded, (_ROUNDED,)) if _is_good(rounded) else (solid, warnings)

    def _mixed(self, trimmed: Solid) -> Attempt | None:
        """Patches for the regions that fail, and for those that fail beside them."""
        reasons = _reasons(self.model, trimmed)
        for _ in range(_MAX_ROUNDS):
            is_failing = np.isin(self.source.label, list(reasons))
            if not reasons or is_failing.mean() > _MAX_SHARE:
                return None
            mixed = patched(*self._beside(reasons), reasons, self.max_move)
            if mixed is None or sum(face.is_patch for face in mixed.faces) > _MAX_PATCHES:
                return None
            model = mixed.transformed(self.to_user)
            solid, _ = _tried(
                # Patches need no repair, and the rung below is better than a repaired guess.
                partial(make_solid, model, self._places, self.spacing, time_limit=0.0)
            )
            if solid is None:
                return None
            if _is_good(solid):
                warnings = tuple(
                    f"region {label} near {self._place(label)} is made of bicubic patches, "
                    f"as its face fails: {reason}"
                    for label, reason in sorted(reasons.items())
                )
                return self._attempt(model, replace(solid, representation="mixed"), warnings)
            more = _reasons(mixed, solid)
            if set(more) <= set(reasons):
                return None
            reasons = more | reasons
        return None

    def _attempt(self, model: Model, solid: Solid | None, warnings: tuple[str, ...]) -> Attempt:
        return Attempt(model, solid, (*self.doubts, *warnings))

    def _given_up(self, reasons: Mapping[int, str], fewer: Ladder, why: str) -> tuple[str, ...]:
        """What to say of regions that another ladder does without."""
        gone = np.setdiff1d(list(self._at(reasons)), fewer.source.label)
        return tuple(
            f"region {label} near {self._place(label)} was given to its neighbours, {why}, "
            f"as {'its face fails: ' + reasons[label] if label in reasons else _BESIDE}"
            for label in gone.tolist()
        )

    def _at(self, regions: Collection[int]) -> set[int]:
        """Some regions and those that share a border with one of them."""
        sides = [{chain.left, chain.right} for chain in self.source.topology.chains]
        return set(regions).union(*(pair for pair in sides if not pair.isdisjoint(regions))) - {-1}

    def _beside(self, regions: Collection[int]) -> tuple[Model, LabelledNet]:
        """The trimmed model and its borders, which are sides of the net beside some regions."""
        if has_sides(self.source, regions):
            return self.model, self.source
        located = self.located_beside(regions)
        return located.model, replace(self.source, topology=located.topology)

    def _place(self, label: int) -> str:
        """Where a region lies, in the user's unit."""
        quads = self.source.net.quads[self.source.label == label]
        middle = np.median(self.source.net.vertices[quads.ravel()], axis=0)
        return "({:.4g}, {:.4g}, {:.4g})".format(*self.to_user.points(middle))


def _tried(build: Callable[[], Solid]) -> tuple[Solid | None, tuple[str, ...]]:
    """The solid, or None and why there is none."""
    try:
        return build(), ()
    except _REFUSALS as error:
        return None, (str(error),)


def _is_good(solid: Solid | None) -> bool:
    return solid is not None and solid.check.is_good


def _gap(model: Model) -> float:
    """The largest gap that a model has at an edge or a vertex."""
    return float(max([0.0, *model.vertex_gaps, *(edge.gap for edge in model.edges)]))


def _reasons(model: Model, solid: Solid) -> dict[int, str]:
    """Why the face of each failing region fails."""
    found: dict[int, dict[str, None]] = {}
    for fault in solid.check.bad_faces:
        if fault.index >= 0:
            found.setdefault(model.faces[fault.index].region, {})[fault.reason] = None
    return {region: ", ".join(list(reasons)[:3]) for region, reasons in found.items()}
