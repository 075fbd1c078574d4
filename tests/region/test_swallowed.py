"""What a region has that it does not explain."""

from types import SimpleNamespace

import numpy as np

from crispline.options import RegionOptions
from crispline.region.regionfit import RegionFit
from crispline.region.swallowed import without_spoils
from crispline.surface import Plane


def test_a_region_that_an_expansion_spoils_gives_back_what_it_cannot_explain():
    """Patches on a line; region 0 explains the first six, and no region the last ones."""
    before = np.repeat([0, 1, 2], [4, 6, 2])
    after = np.repeat([0, 2], [10, 2])
    off = np.where(np.arange(12) < 6, 0.1, 2.0)
    evidence = SimpleNamespace(
        misfit=lambda fit, patches: np.tile(off[patches, None], (1, 3)),
        patch_noise=np.full(12, 0.2),
    )

    def fits(is_accepted):
        surface = Plane(np.zeros(3), np.eye(3)[2])
        fit = RegionFit(surface, 1, np.empty((0, 3)), np.empty(0), is_accepted=is_accepted)
        return {0: fit, 2: fit}

    def kept(now, then):
        return without_spoils(after, before, now, then, evidence, RegionOptions())

    expected = np.repeat([0, 1, 2], [6, 4, 2])
    np.testing.assert_array_equal(kept(fits(False), fits(True)), expected)
    # What is explained still, or never was, keeps all.
    np.testing.assert_array_equal(kept(fits(True), fits(True)), after)
    np.testing.assert_array_equal(kept(fits(False), fits(False)), after)
