"""How the noise of a cloud differs from place to place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.scale import evenly, local_variances
from crispline.surface.base import Array

_N_SAMPLES = 3000  # neighbourhoods that the noise is estimated from
_N_AROUND = 100  # of these, the nearest that tell the noise of a place
_UNEVEN = 1.3  # ratio that creases and chance do not reach over a tenth of a cloud
_UNEVEN_SHARE = 0.1
_MAX_RATIO = 8.0


def noise_levels(points: Array, neighbours: NDArray[np.int64], sigma: float) -> Array:
    """Noise of each point along its normal, shape ``(n,)``, from ``sigma`` to 8 times that.

    The noise of a range camera grows with the square of the distance; what an airborne scanner
    sees of trees is noise of another kind than what it sees of roofs. The noise of a place is
    estimated as :func:`crispline.cloud.scale.local_noise` estimates that of the cloud, from
    the hundred nearest of 3000 neighbourhoods. It is ``sigma`` everywhere if less than a tenth
    of the cloud has 1.3 times as much: creases and chance alone stay below 1.2.

    Parameters
    ----------
    points : shape ``(n, 3)``.
    neighbours : indices of the neighbours of every point, nearest first, shape ``(n, k)``,
        ``k`` over 6.
    sigma : noise of the cloud, the unit of ``points``.
    """
    sample = evenly(len(points), _N_SAMPLES)
    variances = local_variances(points, neighbours[sample])
    is_told = ~np.isnan(variances)
    sample, variances = sample[is_told], variances[is_told]
    places = cKDTree(points[sample])
    _, around = places.query(points[sample], k=min(_N_AROUND, len(sample)))
    around = around.reshape(len(sample), -1)
    level = np.sqrt(np.quantile(variances[around], 0.25, axis=1))
    if np.quantile(level, 1.0 - _UNEVEN_SHARE) < _UNEVEN * sigma:
        return np.full(len(points), sigma)
    _, nearest = places.query(points)
    return np.asarray(np.clip(level, sigma, _MAX_RATIO * sigma)[nearest])
