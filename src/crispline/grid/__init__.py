"""The paper's method where the points, or a surface, are given in rows and columns."""

from crispline.grid.detect import curvature, detect
from crispline.grid.locate import locate
from crispline.grid.preserve import preserve
from crispline.grid.sharpen import Sharpened, sharpen

__all__ = ["Sharpened", "curvature", "detect", "locate", "preserve", "sharpen"]
