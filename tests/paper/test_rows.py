from dataclasses import replace

import pytest

from crispline.paper.measure import Deviation, Hits
from crispline.paper.published import TABLE_I
from crispline.paper.rows import Trial, published_rows, rows_of
from crispline.paper.windows import FEATURES


def trial(seed, before, after, **changes):
    made = Trial(
        method="robust",
        sampling="grid 0.25",
        noise=0.01,
        feature="straight",
        seed=seed,
        before=Deviation(before, 0.1, 0.2),
        after=None if after is None else Deviation(after, 0.01, 0.02),
        found=Hits(10, 9, 100, 95),
        n_windows=12,
        n_failed=0,
    )
    return replace(made, **changes)


def test_a_row_holds_means_and_spreads_over_the_seeds():
    (row,) = rows_of([trial(0, 0.4, 0.04), trial(1, 0.2, 0.01)])
    assert row.initial == pytest.approx(0.3)
    assert row.initial_spread == pytest.approx(0.02**0.5)
    assert row.final == pytest.approx(0.025)
    assert row.final_spread == pytest.approx(0.03 / 2**0.5)
    assert row.reduction == pytest.approx(1.0 - 0.025 / 0.3)
    assert row.reduction_spread == pytest.approx(0.05 / 2**0.5)
    assert (row.reverse_mean, row.reverse_p99) == (0.01, 0.02)
    assert (row.initial_reverse_mean, row.initial_reverse_p99) == (0.1, 0.2)
    assert (row.precision, row.recall) == (0.9, 0.95)
    assert (row.seeds, row.windows, row.failures) == (2, 24, 0)
    assert row.snr_db == pytest.approx(40.0)


def test_one_seed_has_no_spread():
    (row,) = rows_of([trial(0, 0.4, 0.1)])
    assert row.final == 0.1
    assert row.final_spread is None


def test_trials_are_grouped_by_what_they_tried():
    other = trial(0, 0.4, 0.04, sampling="grid 0.50")
    rows = rows_of([trial(0, 0.4, 0.04), other, trial(1, 0.4, 0.04)])
    assert [(row.sampling, row.seeds) for row in rows] == [("grid 0.25", 2), ("grid 0.50", 1)]


def test_what_failed_is_counted_and_leaves_the_rest():
    rows = rows_of([trial(0, 0.4, None, n_failed=1), trial(1, 0.2, 0.01)])
    assert rows[0].final == 0.01
    assert rows[0].failures == 1
    (nothing,) = rows_of([trial(0, 0.4, None, n_failed=1, found=None)])
    assert nothing.final is nothing.reduction is nothing.precision is None


def test_nothing_found_sharp_has_no_precision():
    (row,) = rows_of([trial(0, 0.4, 0.4, found=Hits(0, 0, 100, 0))])
    assert row.precision is None
    assert row.recall == 0.0


def test_published_reductions_are_those_that_the_paper_prints():
    printed = {
        0.0: (1.0, 0.9995, 0.9995, 1.0),
        0.005: (0.8877, 0.8904, 0.8873, 0.8992),
        0.01: (0.7741, 0.7875, 0.7866, 0.8121),
        0.02: (0.4459, 0.4223, 0.4823, 0.4966),
    }
    for level, expected in printed.items():
        rows = published_rows([level])
        assert tuple(row.feature for row in rows) == FEATURES
        for row, share in zip(rows, expected, strict=True):
            assert row.reduction == pytest.approx(share, abs=6e-5)
    assert published_rows([0.05]) == []
    assert [len(features) for features in TABLE_I.values()] == [4] * 4
