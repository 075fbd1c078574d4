"""Patches to regions, each with the one surface that its raw points lie on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crispline.fit.choose import KINDS
from crispline.net.halfedge import HalfEdges
from crispline.options import FitOptions, RegionOptions
from crispline.region.basins import basins, consecutive
from crispline.region.cleanup import tidy
from crispline.region.complete import completed
from crispline.region.evidence import Evidence
from crispline.region.expand import expand_regions
from crispline.region.fitting import SCULPTURE_KINDS, LabelledCloud, fit_regions, label_cloud
from crispline.region.merge import merge_regions
from crispline.region.narrow.restore import restored
from crispline.region.patches import Labels
from crispline.region.prune import prune_regions
from crispline.region.reclaim import reclaimed
from crispline.region.regionfit import RegionFit
from crispline.region.resolve import resolved
from crispline.region.split import split_into_surfaces
from crispline.region.swallowed import release_swallowed, without_spoils
from crispline.region.sweep import with_sweeps
from crispline.surface import FREE_FORMS
from crispline.surface.base import Array

_MERGE_ROUNDS = 8
_COMPLETIONS = 2


@dataclass(frozen=True)
class Segmentation:
    """A labelled net and the surface of every label.

    Attributes
    ----------
    label : region of every patch, 0, 1, ..., shape ``(m,)``.
    fits : surface of every region.
    has_faces : whether the regions are faces of the part, not those of a sculpture.
    """

    label: Labels
    fits: dict[int, RegionFit]
    has_faces: bool


def segment(
    evidence: Evidence,
    net_vertices: Array,
    quads: HalfEdges,
    is_sharp: NDArray[np.bool_],
    options: RegionOptions,
    fit_options: FitOptions,
) -> Segmentation:
    """Basins between the sharp bands, split into surfaces, refined against the raw points.

    Each round fits every region, merges what one surface explains, and moves
    the borders to where the surfaces put them. A sculpture has no faces: where the
    smooth regions fall into crumbs there is no round, and where one explains next to
    nothing no more.

    Parameters
    ----------
    evidence : the patches and the raw points.
    net_vertices, quads : the net that the patches belong to.
    is_sharp : sharp patches, shape ``(m,)``.
    """
    graph = evidence.graph
    label = basins(graph.points, graph.normals, graph.pairs, is_sharp, graph.edge_length, options)
    patch_sigma = options.patch_noise * evidence.patch_noise
    split = split_into_surfaces(label, graph, is_sharp, patch_sigma, options, fit_options)
    label = tidy(split.label, quads, options.min_patches)
    kinds = SCULPTURE_KINDS if split.is_sculpture else KINDS
    known: dict[int, tuple[RegionFit, int]] = {}
    refused: dict[tuple[int, int], tuple[int, int]] = {}

    def fitted(with_options: FitOptions) -> tuple[LabelledCloud, dict[int, RegionFit]]:
        nonlocal known
        labelled = label_cloud(evidence, net_vertices, quads, label)
        known = fit_regions(labelled, graph, label, with_options, known, kinds)
        return labelled, {region: fit for region, (fit, _) in known.items()}

    # Borders settle on a part of the points; only the last fit takes them all.
    draft = replace(fit_options, max_points=options.draft_points)
    before: dict[int, RegionFit] = {}
    spoilt: set[int] = set()
    for round_number in range(0 if split.is_sculpture else options.rounds):
        labelled, fits = fitted(draft)
        spoilt |= {region for region, fit in fits.items() if _is_spoilt(fit, before.get(region))}
        apart = resolved(label, spoilt, graph, is_sharp, patch_sigma, options, draft)
        if not np.array_equal(apart, label):
            label = tidy(apart, quads, options.min_patches)
            labelled, fits = fitted(draft)
        for _ in range(_MERGE_ROUNDS):
            merged = merge_regions(label, fits, labelled, graph, options, draft, refused)
            if np.array_equal(merged, label):
                break
            label = tidy(merged, quads, options.min_patches)
            labelled, fits = fitted(draft)
        shared = reclaimed(label, fits, graph, patch_sigma, options)
        if not np.array_equal(shared, label):
            label = tidy(shared, quads, options.min_patches)
            labelled, fits = fitted(draft)
        for _ in range(_COMPLETIONS):
            label, grown = completed(label, fits, graph, patch_sigma, options)
            changed = {region: (fit, 0) for region, fit in grown.items() if fit is not fits[region]}
            if not changed:
                break
            label = tidy(label, quads, options.min_patches)
            fitted(draft)
            # Not refitted yet: the part of the points that a region has is what misled it.
            known = {**known, **changed}
            fits = {region: fit for region, (fit, _) in known.items()}
        before, unmoved = fits, label
        label = expand_regions(label, fits, evidence, options)
        label = tidy(label, quads, options.min_patches)
        _, fits = fitted(draft)
        clean = without_spoils(label, unmoved, fits, before, evidence, options)
        if not np.array_equal(clean, label):
            label = tidy(clean, quads, options.min_patches)
            _, fits = fitted(draft)
        if explained_share(label, fits) < options.min_explained:
            break
        if round_number > 0:
            label = prune_regions(label, fits, evidence, options)
        if round_number < options.rounds - 1:
            label = release_swallowed(label, fits, evidence, options)
            label = split_into_surfaces(
                label, graph, is_sharp, patch_sigma, options, draft, _unexplained(label, fits)
            ).label
        label = tidy(label, quads, options.min_patches)
    # A sculpture is made of patches: its surfaces only say where its creases are.
    labelled, fits = fitted(draft if split.is_sculpture else fit_options)
    has_faces = not split.is_sculpture
    has_faces &= explained_share(label, fits) >= options.min_explained
    if has_faces:

        def refitted(new: Labels) -> dict[int, RegionFit]:
            nonlocal label
            label = new
            return fitted(fit_options)[1]

        one, swept = with_sweeps(label, fits, labelled, graph, options, fit_options)
        if swept:
            known = {region: (fit, 0) for region, fit in {**fits, **swept}.items()}
            one = expand_regions(one, {**fits, **swept}, evidence, options)
            fits = refitted(tidy(one, quads, options.min_patches))
        label, fits = restored(
            label, fits, refitted, net_vertices, quads, evidence, options, fit_options
        )
    names = np.unique(label)
    return Segmentation(
        consecutive(label),
        {int(np.searchsorted(names, r)): fit for r, fit in fits.items()},
        has_faces,
    )


def explained_share(label: Labels, fits: Mapping[int, RegionFit]) -> float:
    """Share of the patches whose region's points lie on its surface but for the noise."""
    accepted = [region for region, fit in fits.items() if fit.is_accepted]
    return float(np.isin(label, accepted).mean())


def _is_spoilt(fit: RegionFit, before: RegionFit | None) -> bool:
    """Whether a region was a primitive until its borders moved."""
    was_primitive = before is not None and before.surface.kind not in FREE_FORMS
    return was_primitive and fit.surface.kind in FREE_FORMS


def _unexplained(label: Labels, fits: Mapping[int, RegionFit]) -> list[int]:
    """Regions without a fit, or with a primitive that their points do not lie on."""
    return [
        region
        for region in np.unique(label).tolist()
        if region not in fits
        or not (fits[region].is_accepted or fits[region].surface.kind in FREE_FORMS)
    ]
