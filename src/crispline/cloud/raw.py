"""What a reader of one format hands over, before anything is checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class RawCloud:
    """Rows as they stand in a file; `PointCloud.from_arrays` checks them.

    Attributes
    ----------
    points : shape ``(n, 3)``, of any real type; NaN marks invalid ones.
    normals : shape ``(n, 3)``, of any length, or None if the file has none.
    viewpoints : where the scanner stood for each point, shape ``(n, 3)``, or None.
    """

    points: NDArray[np.generic]
    normals: NDArray[np.generic] | None = None
    viewpoints: NDArray[np.generic] | None = None
