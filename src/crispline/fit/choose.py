"""Which kind of surface a region is: the simplest that leaves nothing but noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from crispline.fit.cone import fit_cone
from crispline.fit.cylinder import fit_cylinder
from crispline.fit.dominant import dominant_plane, plane_beside_few, plane_of_most
from crispline.fit.freeform import free_form
from crispline.fit.plane import fit_plane
from crispline.fit.residual import residual_limit, rms, rms_limit
from crispline.fit.robust import thinned
from crispline.fit.sphere import fit_sphere
from crispline.fit.torus import fit_torus
from crispline.fit.verdict import Fit, is_pure_noise, tested
from crispline.options import FitOptions
from crispline.surface import Plane, Surface, unit
from crispline.surface.base import Array

KINDS = ("plane", "cylinder", "sphere", "cone", "torus", "bspline")
"""What may be asked for, in order of preference where several explain the same points; a
B-spline comes out as a surface of revolution where that is enough."""
MIN_FREE_FORM_POINTS = 25

N_CANDIDATE_POINTS = 500
"""Points of a draft."""
CANDIDATE_SLACK = 1.1
"""A draft may leave so many times the residual that a fit may leave."""
_CLIP = 4.0
_NOISE_SHARE = 0.05
"""Chi-square per point that a real scan's nearly flat faces may gain from a huge radius."""


_NEARLY_FLAT = np.radians(5.0)
"""A curved primitive that leans less from its mean direction may be a plane."""

_COMPLEXITY = {"cylinder": 5, "sphere": 6, "cone": 6, "torus": 7}
"""Parameters charged for a shape. A sphere has four, but on a narrow band it fits as well
as the far commoner cylinder and cone, so it needs as much evidence as a cone."""


class PrimitiveFit(Protocol):
    """The signature shared by all primitive fits."""

    def __call__(
        self,
        points: Array,
        normals: Array,
        sigma: float,
        start: Any = None,
        is_draft: bool = False,
        /,
    ) -> Surface | None: ...


PRIMITIVE_FITS: dict[str, PrimitiveFit] = {
    "plane": fit_plane,
    "cylinder": fit_cylinder,
    "sphere": fit_sphere,
    "cone": fit_cone,
    "torus": fit_torus,
}


def choose_surface(
    points: Array,
    normals: Array,
    sigma: float,
    options: FitOptions,
    kinds: Sequence[str] = KINDS,
    border_distance: Array | None = None,
) -> Fit:
    """Fit a region with the kind of surface that describes it best.

    A plane if it passes the residual test and leaves no more than noise.
    Otherwise the primitive of least robust chi-square plus ``2 k log n`` (a
    description length; ``k`` free parameters) that passes; a plane that passes
    too gives way only where that pays. What none of these leaves as noise is a plane with
    strips of its neighbours if :func:`crispline.fit.dominant.dominant_plane` says so, else
    what :func:`crispline.fit.freeform.free_form` finds, or a plane that a few foreign points do
    not lie on if that is cheaper.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings; at least three, not on one line.
    normals : oriented unit normals, shape ``(n, 3)``.
    sigma : noise along the normal, spacings.
    options : thresholds. More than ``options.max_points`` points are thinned.
    kinds : the kinds to consider, of :data:`KINDS`.
    border_distance : distance of each point from the region's border, shape
        ``(n,)``, spacings; B-splines and planes with strips of neighbours use it.

    Returns
    -------
    The fit. If nothing passes: the B-spline of least drift where the region is
    a height field of at least 25 points, else the primitive of least residual, else (too
    few points, or all on a line) the plane across their mean normal; ``is_accepted`` is then
    False.

    Raises
    ------
    ValueError
        If no surface of the wanted kinds can be fitted at all.
    """
    sigma = max(sigma, options.sigma_floor)
    kept = thinned(len(points), options.max_points)
    points, normals = points[kept], normals[kept]
    flat: Fit | None = None
    if "plane" in kinds and (plane := fit_plane(points, normals, sigma)) is not None:
        flat = tested(plane, points, sigma, options, normals)
        if flat.is_accepted and is_pure_noise(flat.rms, flat.n_points, sigma):
            return flat

    def under() -> Fit | None:
        """The plane below strips of neighbours."""
        if border_distance is None or "plane" not in kinds:
            return None
        plane = dominant_plane(points, normals, border_distance[kept], sigma)
        if plane is None:
            return None
        return replace(tested(plane, points, sigma, options, normals), is_accepted=True)

    rejected = [] if flat is None else [flat]
    for candidate in _ranked_candidates(points, normals, sigma, options, kinds):
        surface = PRIMITIVE_FITS[candidate.kind](points, normals, sigma, candidate)
        if surface is None:
            continue
        fit = tested(surface, points, sigma, options, normals)
        if fit.is_accepted:
            if not is_pure_noise(fit.rms, fit.n_points, sigma) and (main := under()) is not None:
                return main
            if (level := plane_of_most(points, normals, surface, sigma)) is not None:
                return replace(tested(level, points, sigma, options, normals), is_accepted=True)
            is_needed = flat is None or not flat.is_accepted or _is_worth(fit, flat, sigma, options)
            return fit if is_needed or flat is None else flat
        rejected.append(fit)
    if flat is not None and flat.is_accepted:
        return flat
    if (main := under()) is not None:
        return main
    if "bspline" in kinds and len(points) >= MIN_FREE_FORM_POINTS:
        distance = None if border_distance is None else border_distance[kept]
        free = free_form(points, normals, sigma, options, distance)
        if free is not None:
            few = None
            if "plane" in kinds:
                few = plane_beside_few(points, normals, free.surface, sigma)
            if few is None:
                return free
            return replace(tested(few, points, sigma, options, normals), is_accepted=True)
    if not rejected and "plane" in kinds and len(points):
        # Too few points for anything, as on a region that is one patch: their tangent plane.
        normal = normals.mean(axis=0)
        heading = unit(normal) if normal.any() else normals[0]
        touching = Plane(points.mean(axis=0), heading)
        return replace(tested(touching, points, sigma, options, normals), is_accepted=False)
    if not rejected:
        raise ValueError(f"none of {', '.join(kinds)} fits {len(points)} points")
    return min(rejected, key=lambda fit: fit.rms)


def refit(
    known: Surface, points: Array, normals: Array, sigma: float, options: FitOptions
) -> Fit | None:
    """Fit the same kind of primitive again to points that have changed a little.

    None if ``known`` is no primitive or its kind no longer passes, or if it is nearly flat and
    a plane leaves nothing but noise: choose anew.
    """
    if known.kind not in PRIMITIVE_FITS:
        return None
    sigma = max(sigma, options.sigma_floor)
    kept = thinned(len(points), options.max_points)
    surface = PRIMITIVE_FITS[known.kind](points[kept], normals[kept], sigma, known)
    if surface is None:
        return None
    fit = tested(surface, points[kept], sigma, options, normals[kept])
    if not fit.is_accepted:
        return None
    # A plane that passes with more than noise left may be a gentle curve, and a curve of which
    # a border took a part, or that strips of a neighbour bent, may be a plane: weigh them again.
    if known.kind == "plane":
        is_doubtful = not is_pure_noise(fit.rms, fit.n_points, sigma)
    elif plane_of_most(points[kept], normals[kept], surface, sigma) is not None:
        is_doubtful = True
    else:
        is_doubtful = _is_flat(surface, points[kept], normals[kept], sigma, options)
    return None if is_doubtful else fit


def _is_flat(
    surface: Surface, points: Array, normals: Array, sigma: float, options: FitOptions
) -> bool:
    """Whether a surface hardly turns over its points and a plane leaves but noise of them."""
    if len(points) < MIN_FREE_FORM_POINTS or not _hardly_turns(surface, points):
        return False
    plane = fit_plane(points, normals, sigma)
    if plane is None:
        return False
    flat = tested(plane, points, sigma, options, normals)
    return flat.is_accepted and is_pure_noise(flat.rms, flat.n_points, sigma)


def _hardly_turns(surface: Surface, points: Array) -> bool:
    """Whether a surface is nearly flat at points ``(n, 3)``, but for a twentieth of them."""
    directions = surface.project(points)[1]
    middle = unit(directions.mean(axis=0))
    return bool(np.quantile(directions @ middle, 0.05) > np.cos(_NEARLY_FLAT))


def _is_worth(fit: Fit, flat: Fit, sigma: float, options: FitOptions) -> bool:
    """Whether a curved surface explains enough more than a plane to be preferred."""
    gain = fit.n_points * (flat.rms**2 - fit.rms**2) / sigma**2
    spared = fit.surface.n_parameters - flat.surface.n_parameters
    share = max(_NOISE_SHARE, options.shared_variance)
    return gain > max(2.0 * spared * float(np.log(fit.n_points)), share * fit.n_points)


def _ranked_candidates(
    points: Array, normals: Array, sigma: float, options: FitOptions, kinds: Sequence[str]
) -> list[Surface]:
    """Curved primitives that nearly pass on a subset, by robust description length."""
    kept = thinned(len(points), N_CANDIDATE_POINTS)
    limit = CANDIDATE_SLACK * rms_limit(sigma, options)
    cut = residual_limit(sigma, options)
    scored: list[tuple[float, str, Surface]] = []
    pure_noise = False
    for kind in kinds:
        if kind not in PRIMITIVE_FITS or kind == "plane":
            continue
        if kind == "torus" and pure_noise:
            break  # the dearest to fit, and with nothing left to explain
        # A torus creeps to its place: a draft of it tells nothing.
        is_draft = kind != "torus"
        surface = PRIMITIVE_FITS[kind](points[kept], normals[kept], sigma, None, is_draft)
        if surface is None:
            continue
        residuals = surface.signed_distance(points[kept])
        size = rms(np.clip(residuals, -cut, cut))
        if size < limit:
            pure_noise |= is_pure_noise(size, len(kept), sigma)
            chi_square = float(np.sum(np.minimum(np.square(residuals / sigma), _CLIP**2)))
            cost = 2.0 * _COMPLEXITY[kind] * float(np.log(len(points)))
            scored.append((chi_square + cost, kind, surface))
    return [surface for *_, surface in sorted(scored, key=lambda item: item[:2])]
