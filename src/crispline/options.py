"""Every setting of the program, with its unit and default.

Lengths are in point spacings, noise in sigmas, angles in degrees. Nothing here
depends on the unit or the size of a model.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Surface = Literal["auto", "open", "closed"]
Normals = Literal["auto", "file", "none"]


@dataclass(frozen=True)
class CloudOptions:
    """Points in."""

    outlier_factor: float = 2.0
    """A point is an outlier if its mean distance to 8 neighbours is this many times the median of
    its 24 neighbours', or that of the whole cloud ..."""
    outlier_scatter: float = 0.08
    """... and the points round it scatter: smallest share of a principal component."""
    max_noise: float = 0.4
    """Where the noise of a scan is more than this, in spacings, averages of its points stand for
    them ..."""
    average_noise: float = 0.2
    """... as many to each as make the noise of the averages this, in their own spacings ..."""
    max_points: int = 200_000
    """... and so do averages where a scan has more points than this."""


@dataclass(frozen=True)
class NetOptions:
    """Quad net over the cloud."""

    normals: Normals = "auto"
    """What normals and scanner positions in the file count: ``auto`` uses them if they agree with
    each other and with the points, ``file`` in any case, ``none`` never."""
    normal_neighbours: tuple[int, ...] = (18, 24, 14)
    """Neighbourhood sizes tried for the normals, in this order."""
    good_spread: float = 0.2
    """Spread of the indicator at the points that ends the search for an orientation."""
    edge_lengths: tuple[float, ...] = (1.0, 0.95, 1.05, 0.9)
    """Edge length of the quads, in spacings; the next is tried if a net comes out open."""
    projection_steps: tuple[int, int] = (3, 4)
    """Projection steps onto the cloud before and after quad meshing."""
    surface: Surface = "auto"
    """Whether the surface closes over what the scan left out; ``auto``: closed if every gap is
    narrower than ``fill_holes``."""
    fill_holes: float = 6.0
    """Widest gap in the scan that is closed on an open surface, in spacings."""
    min_piece: int = 100
    """A separate piece of surface needs as many points as this, or it is left out."""


@dataclass(frozen=True)
class DetectOptions:
    """Flat, curved and sharp patches."""

    curved_floor: float = 0.05
    """Smallest curvature threshold, in 1/edge length of the net."""
    curved_sigmas: float = 1.0
    """Curvature threshold per noise sigma over edge length, in 1/edge length."""
    rings: int = 3
    """How many rings of patches around a curved patch are searched for flat ones."""
    spread_deg: float = 20.0
    """A curved patch is sharp if flat patches around it face directions this far apart."""


@dataclass(frozen=True)
class RegionOptions:
    """Patches to regions."""

    cut_deg: float = 10.0
    """Neighbouring patches whose normals differ by more than this are cut apart."""
    peak_floor: float = 1.5
    """Basins join if the lower peak rises less than this above the pass, in edge lengths ..."""
    peak_share: float = 0.5
    """... or less than this share of its own height."""
    min_patches: int = 12
    """Smaller basins are given to their neighbours."""
    seed_patches: int = 48
    """Patches that a primitive is first fitted to when a smooth region is split."""
    grow_deg: float = 10.0
    """Patches join a growing primitive if their normal is within this of its normal."""
    min_free_patches: int = 25
    """Smaller leftovers of a split region are given to their neighbours."""
    patch_noise: float = 0.7
    """Noise of patch centres over noise of the points."""
    merge_deg: float = 18.0
    """Neighbours whose surfaces meet at less than this are tried as one free-form surface ..."""
    max_merge_deg: float = 60.0
    """... and at less than this as one primitive, which two strips of a narrow fillet are."""
    swallowed_sigmas: float = 1.8
    """Patches whose points lie this many sigmas off every surface near them may be a lost face."""
    swallowed_floor: float = 0.08
    """Smallest sigma used for that, in spacings: patches round off what is smaller than them."""
    expansion_rings: int = 6
    """Patches this many rings from a border may change their label when borders are optimised."""
    expansion_moves: int = 4
    """How often that reach may move on with the borders, each round."""
    border_cost: float = 1.0
    """Cost of a side of border, in units of one point's squared residual over 2 sigma^2."""
    border_miss: float = 1.0
    """A border this far from a surface that it bounds costs ``border_cost`` more, in spacings."""
    border_miss_cap: float = 4.0
    """The extra cost grows with the square of that distance, up to this many ``border_cost``."""
    face_cost: float = 40.0
    """Misfit that a face must explain to be kept, in the units of ``border_cost``."""
    max_pruned_patches: int = 300
    """Larger regions are kept whatever they explain."""
    draft_points: int = 1000
    """Raw points per fit while the borders still move."""
    min_explained: float = 0.4
    """If surfaces explain less than this share of the scan after a round, it has no faces to be
    found: there are no more rounds, and bicubic patches are tried before trimmed faces."""
    crumb_patches: int = 150
    """Pieces of a smooth region smaller than this are crumbs ..."""
    many_crumbs: int = 40
    """... fewer than this are rounds and bosses of a part that has faces ..."""
    max_loose: float = 0.3
    """... and if there are more, and more than this share of the smooth regions is no larger piece
    of a primitive, it is a sculpture: patches are tried first."""
    ring_gap: float = 2.0
    """Gaps of a narrow face round an axis are closed over patches so near to it, in spacings."""
    step_height: float = 0.5
    """Parallel planes with a border, farther apart than this, have the wall of a step between
    them, in spacings ..."""
    max_step_height: float = 4.0
    """... and nearer than this: of a higher one enough points are left to find it, in spacings."""
    step_sides: int = 6
    """Shortest border along which the wall of a step is looked for, in patches."""
    rounds: int = 3
    """Rounds of fitting, merging and optimising the borders."""


@dataclass(frozen=True)
class FitOptions:
    """Regions to surfaces."""

    sigma_floor: float = 0.05
    """Smallest noise assumed, in spacings; keeps noise-free clouds from over-splitting."""
    border_margin: float = 0.8
    """Raw points closer than this to a region border do not enter a fit, in spacings."""
    shallow_deg: float = 30.0
    """A curved primitive that turns less than this over its region may be part of a free form."""
    max_points: int = 5000
    """Raw points per fit; larger regions are thinned evenly."""
    accept_rms: float = 1.25
    """A surface explains a region if its rms residual is below this many sigmas."""
    accept_drift: float = 1.8
    """... and its 30-neighbour mean residual is below this many sigma / sqrt(30)."""
    tolerance: float = 0.02
    """Slack added to both acceptance tests, in spacings."""
    noise_growth: float = 0.0
    """Noise over a face over that of 24 neighbouring points: more than 1 where points err together
    with those round them; 0 means that the cloud tells."""
    regularize: bool = True
    """Make surfaces parallel, perpendicular, coaxial, equal in radius where noise explains it."""

    @property
    def shared_variance(self) -> float:
        """Share of the variance of the noise that a point has in common with those round it."""
        return 1.0 - 1.0 / max(self.noise_growth, 1.0) ** 2


@dataclass(frozen=True)
class LocateOptions:
    """Corners and creases on the fitted surfaces."""

    smooth_angle_deg: float = 12.0
    """A border whose two surfaces meet at less than this is tangent, not sharp ..."""
    sculpture_angle_deg: float = 25.0
    """... and on a sculpture, whose surfaces are less certain, at less than this."""
    corner_gap: float = 0.3
    """Largest distance of a corner to its surfaces, in spacings."""
    corner_cloud_distance: float = 1.6
    """Largest distance of a corner from the cloud, in spacings."""
    corner_move: float = 3.0
    """Largest distance of a corner from its net vertex, in spacings ..."""
    corner_move_smooth: float = 8.0
    """... when a smooth border ends there ..."""
    corner_move_exact: float = 15.0
    """... and when the corner is exact and well conditioned."""
    crease_cloud_distance: float = 2.2
    """Largest distance of any point of a crease from the cloud, in spacings."""
    curve_tolerance: float = 1e-5
    """Interpolated crease curves agree with both surfaces within this, in spacings."""
    rim_raggedness: float = 1.0
    """How far the end of the points may stray from a straight or round rim, in spacings; half of
    it in the root mean square."""
    settle_move: float = 0.75
    """Vertices of the net this near to the surface of their region are moved onto it, in
    spacings."""
    preserve_move: float = 1.5
    """An edge farther than this from its side of the net is not put into the bicubic surface, in
    spacings: the patches beside it would fold over."""
    collapse_length: float = 6.0
    """Chains shorter than this may collapse to a corner, in spacings ..."""
    collapse_distance: float = 0.35
    """... when their two corners are located this close to each other."""


@dataclass(frozen=True)
class SharpenOptions:
    """Sharp features of a grid or a B-spline surface, see :func:`crispline.grid.sharpen`."""

    rule: Literal["robust", "paper"] = "robust"
    """``paper``: one threshold, 4 flat of 8 neighbours, planes from these. ``robust``: any
    position of a feature between the rows, noise, curved sides."""
    eps: float | None = None
    """Curvature above which a patch is curved, in 1/spacing; None: 0.25 for the paper's rule, from
    the noise for the robust one."""
    repeat: int = 3
    """Multiplicity of a feature's knots, 1 to 3; 3 is sharp."""
    curved_floor: float = 0.05
    """Smallest automatic threshold, in 1/spacing."""
    noise_quantile: float = 5.0
    """Automatic threshold, in standard deviations of the curvature that noise makes on flat
    ground."""
    spread_deg: float = 20.0
    """Sides of a sharp edge meet at more than this."""
    support: int = 9
    """Points within this of a feature tell where its sides go, in cells."""
    max_gap: float = 0.01
    """Largest distance of a located point to its sides, in spacings."""
    max_move: float = 1.5
    """Largest distance of a located point from where its sides were expected to meet, in
    spacings."""
    max_rounding: float = 0.3
    """A feature is a rounding, not an edge, if the points near it lie farther than this from
    its sides on the average, in spacings, and noise does not explain it."""


@dataclass(frozen=True)
class Options:
    """All options of :func:`crispline.reconstruct`."""

    seed: int = 0
    """Random seed; the same seed gives the same result."""
    threads: int = 0
    """Threads for neighbour queries and transforms; 0 means all cores. Never changes the result."""
    model: Literal["auto", "trimmed", "patches"] = "auto"
    """``trimmed`` faces, bicubic ``patches``, or the first of trimmed, mixed and patches that
    holds."""
    cloud: CloudOptions = field(default_factory=CloudOptions)
    net: NetOptions = field(default_factory=NetOptions)
    detect: DetectOptions = field(default_factory=DetectOptions)
    region: RegionOptions = field(default_factory=RegionOptions)
    fit: FitOptions = field(default_factory=FitOptions)
    locate: LocateOptions = field(default_factory=LocateOptions)
