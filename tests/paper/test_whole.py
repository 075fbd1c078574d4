"""The pipeline's column on a small cloud: what is measured is the STEP file."""

import numpy as np
import pytest

from crispline import pipeline
from crispline.errors import ReconstructionError
from crispline.paper.rows import rows_of
from crispline.paper.whole import WholeRun, feature_points
from crispline.paper.windows import FEATURES
from crispline.shapes import box_cylinder, sample

# At 3,000 points the rows beside an edge lie exactly on a fillet of 1.3 spacings, which is found.
SMALL = WholeRun("half-cell", 0.0, 0, n_points=4000)


def test_every_feature_is_measured_before_and_after():
    rows = rows_of(SMALL.trials(threads=1))
    assert tuple(row.feature for row in rows) == FEATURES
    for row in rows:
        assert row.sampling == "grid 0.50"
        assert 0.2 < row.initial < 1.5
        assert row.final < 0.05
        assert row.reverse_p99 < 0.05 < row.initial_reverse_p99
        assert row.precision is None
        assert row.failures == 0


def test_a_cloud_without_a_model_is_a_failure(monkeypatch):
    def fail(*_):
        raise ReconstructionError("no solid was built")

    monkeypatch.setattr(pipeline, "reconstruct", fail)
    for trial in SMALL.trials(threads=1):
        assert trial.after is None
        assert trial.n_failed == 1
        assert np.isfinite(trial.before.error)


@pytest.mark.parametrize(
    ("feature", "n_points"),
    [("straight", 1200), ("lower circle", 100), ("upper circle", 100), ("corner", 8)],
)
def test_a_hundred_points_an_edge(feature, n_points):
    scan = sample(box_cylinder(), 1000)
    assert feature_points(scan, feature).shape == (n_points, 3)
