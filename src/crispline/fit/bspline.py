from crispline.options import FitOptions
from crispline.surface import BSplineSurface
from crispline.surface.base import Array


def fit_bspline_surface(
    points: Array,
    normals: Array,
    sigma: float,
    options: FitOptions,
    constraints: None = None,
    border_distance: Array | None = None,
) -> BSplineSurface | None:
    return None
