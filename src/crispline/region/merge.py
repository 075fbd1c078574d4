"""Join neighbouring regions that one surface explains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from crispline.fit.bspline import fit_bspline_surface
from crispline.fit.dominant import dominant_plane, dominates
from crispline.fit.jointly import fit_jointly
from crispline.fit.residual import rms
from crispline.fit.robust import thinned
from crispline.fit.starts import extent
from crispline.fit.verdict import explains, is_pure_noise
from crispline.options import FitOptions, RegionOptions
from crispline.region.fitting import LabelledCloud
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import FREE_FORMS, BSplineSurface, Cylinder, Surface
from crispline.surface.base import Array

Pair = tuple[int, int]
Samples = tuple[Array, Array, Array]

_CHANGED = 0.05  # share of its patches by which a region must change to be tried again
MIN_BORDER = 3  # sides; regions that touch less are not neighbours
_CHI_SQUARE_CAP = 16.0
_MOST_POINTS = 10_000  # whose residuals are summed: what two surfaces differ by at so many tells
_HOPELESS = 1.25  # times what noise explains: the last corrections of a spline win far less
_NOISE_SHARE = 0.02  # fits differ by this much per point for reasons that are no faces
_COMPARABLE = 0.2  # share of the larger piece's points that the smaller must have
_FINER = 1.7  # control points of a B-spline over its own before it took a neighbour; steps are 1.5
_SWEEP_RATIO = 1.15  # of the radii of two cylinders that approximate one bent round ...
_SWEEP_SIGMAS = 3.0  # ... and how far it leaves them
_JOINT_KINDS = ("plane", "cylinder", "cone", "sphere")


def merge_regions(
    label: Labels,
    fits: Mapping[int, RegionFit],
    labelled: LabelledCloud,
    graph: PatchGraph,
    options: RegionOptions,
    fit_options: FitOptions,
    refused: dict[Pair, Pair],
) -> Labels:
    """One round of merges over the longest smooth borders; each region joins at most once.

    Parameters
    ----------
    fits : surface of every label.
    refused : pairs already found not to be one surface, and their sizes then; updated, so
        that later rounds try them again only if they have changed since.
    """
    label = label.copy()
    size = np.bincount(label)
    joined: set[int] = set()
    for (a, b), sides, angle_deg in gentle_borders(label, fits, graph, options.max_merge_deg):
        sizes = (int(size[a]), int(size[b]))
        if sides < MIN_BORDER or a in joined or b in joined:
            continue
        if (a, b) in refused and _are_alike(sizes, refused[a, b]):
            continue
        parts = [labelled.samples(region, fit_options) for region in (a, b)]
        if not all(len(points) for points, _, _ in parts):  # the net spans a gap in the cloud
            continue
        is_smooth = angle_deg < options.merge_deg
        sigma = labelled.sigma(a, b)
        pair = [fits[a], fits[b]]
        if _is_one_plane(parts, pair, sigma, fit_options) or _is_one_surface(
            parts, pair, is_smooth, sigma, fit_options
        ):
            label[label == b] = a
            joined |= {a, b}
        else:
            refused[a, b] = sizes
    return label


def _are_alike(sizes: Pair, before: Pair) -> bool:
    """Whether two regions have hardly changed: borders move by a patch here and there."""
    return all(abs(n - m) <= _CHANGED * m for n, m in zip(sizes, before, strict=True))


def gentle_borders(
    label: Labels, fits: Mapping[int, RegionFit], graph: PatchGraph, max_deg: float
) -> list[tuple[Pair, int, float]]:
    """Neighbouring regions whose surfaces meet at less than ``max_deg``, longest border first.

    Each with the number of its sides and the median angle between the surfaces in degrees;
    a surface that does not explain its region gives way to the patches beside the border.
    """
    a, b = label[graph.pairs[:, 0]], label[graph.pairs[:, 1]]
    between = np.flatnonzero(a != b)
    middle = graph.points[graph.pairs[between]].mean(axis=1)
    low, high = np.minimum(a, b)[between], np.maximum(a, b)[between]
    order = np.lexsort((high, low))
    breaks = np.flatnonzero(np.diff(low[order]) | np.diff(high[order])) + 1
    found = []
    for group in np.split(order, breaks) if len(order) else []:
        pair = (int(low[group[0]]), int(high[group[0]]))
        if all(fits[region].is_accepted for region in pair):
            sides = [fits[r].surface.project(middle[group])[1] * fits[r].orientation for r in pair]
        else:
            sides = list(np.swapaxes(graph.normals[graph.pairs[between[group]]], 0, 1))
        cosine = float(np.median(np.einsum("ij,ij->i", *sides)))
        angle_deg = float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
        if angle_deg < max_deg:
            found.append((pair, len(group), angle_deg))
    return sorted(found, key=lambda item: (-item[1], item[0]))


def _is_one_plane(
    parts: list[Samples],
    fits: list[RegionFit],
    sigma: float,
    options: FitOptions,
) -> bool:
    """Whether one plane lies below both regions but for strips of their neighbours.

    Tried where a surface leaves more than noise; two that leave none are compared by all of
    their points.
    """
    sigma = max(sigma, options.sigma_floor)
    if all(is_pure_noise(rms(fit.residuals), max(len(fit.residuals), 1), sigma) for fit in fits):
        return False
    points, normals, clearance = (np.concatenate(both) for both in zip(*parts, strict=True))
    kept = thinned(len(points), _MOST_POINTS)
    plane = dominant_plane(points[kept], normals[kept], clearance[kept], sigma)
    return plane is not None and all(dominates(plane, *part, sigma) for part in parts)


def _is_one_surface(
    parts: list[Samples],
    fits: list[RegionFit],
    is_smooth: bool,
    sigma: float,
    options: FitOptions,
) -> bool:
    """Whether one primitive, or one B-spline in place of another, explains both regions."""
    both = [(points, normals) for points, normals, _ in parts]
    joint = fit_jointly(_joint_kinds(fits), both, sigma, options)
    if joint is not None:
        apart = [(fit.surface, points) for fit, (points, _) in zip(fits, both, strict=True)]
        together = [(joint, points) for points, _ in both]
        spared = sum(fit.surface.n_parameters for fit in fits) - joint.n_parameters
        n_points = sum(len(points) for points, _ in both)
        share = max(_NOISE_SHARE, options.shared_variance)
        allowance = max(2.0 * spared * np.log(n_points), share * n_points)
        if chi_square(together, sigma) < chi_square(apart, sigma) + allowance:
            return True
    return is_smooth and _is_one_free_form(parts, fits, sigma, options)


def _joint_kinds(fits: list[RegionFit]) -> tuple[str, ...]:
    """Kinds of primitive that may explain two regions; no torus has a flat piece."""
    is_flat = any(fit.surface.kind == "plane" for fit in fits)
    return _JOINT_KINDS if is_flat else (*_JOINT_KINDS, "torus")


def _is_one_free_form(
    parts: list[Samples],
    fits: list[RegionFit],
    sigma: float,
    options: FitOptions,
) -> bool:
    """Whether one B-spline explains two smooth neighbours as pieces of one free-form face.

    Either both are pieces of comparable size, shallow or of one sweep, or a B-spline goes on over
    its neighbour without becoming much finer. A B-spline fine enough explains
    any smooth neighbour, fillets and planes too; that would be no explanation.
    """
    free_forms = [fit for fit in fits if fit.surface.kind == "bspline"]
    # What no B-spline explains by itself it does not explain together with more.
    if not all(fit.is_accepted for fit in free_forms):
        return False
    surfaces = [fit.surface for fit in free_forms]
    splines = [s.control_points.size for s in surfaces if isinstance(s, BSplineSurface)]
    sizes = sorted(len(points) for points, _, _ in parts)
    if not splines and sizes[0] < _COMPARABLE * sizes[1]:
        return False
    if not (splines or _is_sweep(fits, sigma) or all(_is_shallow(fit, options) for fit in fits)):
        return False
    points = np.concatenate([points for points, _, _ in parts])
    normals = np.concatenate([normals for _, normals, _ in parts])
    clearance = np.concatenate([clearance for _, _, clearance in parts])
    # What a region needs by itself, it needs together with more.
    needed = max(splines, default=0)
    finest = _FINER * needed if splines else np.inf
    kept = thinned(len(points), 2 * options.max_points)
    lenient = replace(
        options,
        accept_rms=_HOPELESS * options.accept_rms,
        accept_drift=_HOPELESS * options.accept_drift,
        tolerance=_HOPELESS * options.tolerance,
    )
    free = fit_bspline_surface(
        points[kept],
        normals[kept],
        sigma,
        options,
        border_distance=clearance[kept],
        within=(needed / _FINER, finest),
        is_promising=lambda surface: _explains_all(surface, parts, sigma, lenient),
    )
    if free is None or free.n_parameters > finest:
        return False
    return _explains_all(free, parts, sigma, options)


def _explains_all(
    surface: Surface, parts: list[Samples], sigma: float, options: FitOptions
) -> bool:
    """Whether a surface explains every part; the smallest, which costs least, is asked first."""
    return all(
        explains(surface, points, normals, sigma, options)
        for points, normals, _ in sorted(parts, key=lambda part: len(part[0]))
    )


def _is_sweep(fits: list[RegionFit], sigma: float) -> bool:
    """Whether two cylinders may be pieces of one round that bends, a fillet for instance.

    A round that turns as much as their axes do leaves either cylinder by an eighth of
    its length times the turn. Noise must hide that: cylinders that fit too well for it
    meet in a mitre.
    """
    first, second = (fit.surface for fit in fits)
    if not (isinstance(first, Cylinder) and isinstance(second, Cylinder)):
        return False
    ratio = first.radius / second.radius
    turn = float(np.arccos(min(abs(float(first.axis @ second.axis)), 1.0)))
    length = min(extent(fit.points) for fit in fits)
    is_hidden = length * turn / 8.0 < _SWEEP_SIGMAS * sigma
    return is_hidden and 1.0 / _SWEEP_RATIO < ratio < _SWEEP_RATIO


def _is_shallow(fit: RegionFit, options: FitOptions) -> bool:
    """Whether a curved surface turns so little over its region that it may be free form.

    A few degrees of a cylinder or torus of a huge radius are what pieces of a
    free-form face look like; a plane is a plane.
    """
    if fit.surface.kind in ("plane", *FREE_FORMS) or not len(fit.points):
        return False
    normals = fit.surface.project(fit.points)[1]
    middle = normals.mean(axis=0)
    length = float(np.linalg.norm(middle))
    if length == 0.0:
        return False
    reach = float(np.quantile(normals @ middle / length, 0.05))
    return reach > float(np.cos(np.radians(0.5 * options.shallow_deg)))


def chi_square(explained: list[tuple[Surface, Array]], sigma: float) -> float:
    """Sum of squared residuals over sigma squared, each capped so that outliers do not decide.

    Very many points are told by an even sample of them; of the same points it is the same one.
    """
    total = 0.0
    for surface, points in explained:
        few = points[thinned(len(points), _MOST_POINTS)]
        squared = np.minimum(np.square(surface.signed_distance(few) / sigma), _CHI_SQUARE_CAP)
        total += len(points) / max(len(few), 1) * float(squared.sum())
    return total
