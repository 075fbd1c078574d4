"""The referee on models whose figures can be told by hand."""

import json

import numpy as np
import pytest

import referee
from crispline import occt
from crispline.occt.measure import tessellate
from crispline.surface import Similarity
from parts.modelling import box, cylinder, fuse
from parts.scan import scan

SIZE = np.array([60.0, 40, 30])
N_POINTS = 8000


@pytest.fixture(scope="module")
def truth():
    return scan(box(SIZE), N_POINTS, noise=0.001)[0]


def moved(shape, shift):
    return occt.transform(shape, Similarity(1.0, np.eye(3), np.asarray(shift, float)))


def test_the_truth_itself_is_perfect(truth):
    found = referee.score(box(SIZE), truth)
    assert found.is_valid
    assert found.is_closed
    assert (found.n_solids, found.n_faces, found.n_true_faces) == (1, 6, 6)
    rates = "edge_precision", "edge_recall", "edge_f1", "corner_precision", "corner_recall"
    assert {getattr(found, name) for name in rates} == {1.0}
    for name in ("edge_error", "feature_to_surface", "surface_max", "reverse_p99"):
        assert getattr(found, name) == pytest.approx(0.0, abs=1e-6)
    assert found.recovered == [(0, 0), (0, 0), (6, 6)]


def test_a_small_shift_keeps_the_features_and_shows_in_the_distances(truth):
    shift = 0.6 * truth.spacing
    found = referee.score(moved(box(SIZE), [shift, 0, 0]), truth)
    assert found.edge_f1 == 1.0
    assert found.corner_recall == 1.0
    # The two faces across x are 0.6 off, the rest slide in themselves except at their ends.
    across = 40 * 30 / (60 * 40 + 60 * 30 + 40 * 30)
    assert found.surface_mean == pytest.approx(0.6 * across, abs=0.02)
    assert found.reverse_mean == pytest.approx(0.6 * across, abs=0.02)
    # Edges across x are 0.6 off, edges along x not.
    assert found.edge_error == pytest.approx(0.6 * 70 / 130, abs=0.01)


def test_a_larger_shift_loses_the_edges_across_it_and_all_corners(truth):
    shift = 1.5 * truth.spacing
    found = referee.score(moved(box(SIZE), [shift, 0, 0]), truth)
    # Of the edges along x, all but half a spacing at one end is within one spacing; of those
    # across x, one spacing at each of the 8 ends that the other's edges along x run past.
    kept = (4 * (60 - 0.5 * truth.spacing) + 8 * truth.spacing) / (4 * (60 + 40 + 30))
    assert found.edge_recall == pytest.approx(kept, abs=0.005)
    assert found.edge_precision == pytest.approx(kept, abs=0.005)
    assert found.corner_recall == found.corner_precision == 0.0


def test_what_is_too_much_shows_in_precision_and_reverse_only(truth):
    found = referee.score(fuse(box(SIZE), box((10, 10, 20), (20, 20, 30))), truth)
    assert found.edge_recall == 1.0
    assert found.edge_precision == pytest.approx(4 * 130 / (4 * 130 + 2 * 40 + 4 * 20), abs=0.01)
    assert found.corner_recall == 1.0
    assert found.corner_precision == 0.5
    assert found.reverse_p99 > 10.0
    assert found.surface_max > 3.0  # the ground under the tower lies inside now
    assert found.recovered == [(0, 0), (0, 0), (6, 6)]


def test_a_sheet_is_open(truth):
    face = occt.subshapes(box(SIZE), occt.FACE)[0]
    found = referee.score(face, truth)
    assert not found.is_closed
    assert found.n_faces == 1
    assert found.edge_precision == found.edge_recall == 0.0


def test_distances_to_a_model_are_those_to_the_solid(truth):
    mesh = tessellate(cylinder(20, 50), 0.001, 0.05)
    stream = np.random.default_rng(1)
    angle, z = stream.uniform(0, 2 * np.pi, 500), stream.uniform(5, 45, 500)
    radius = stream.uniform(16, 24, 500)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
    expected = np.minimum(np.abs(radius - 20), np.where(radius < 20, np.minimum(z, 50 - z), 99))
    distance, _ = referee._to_model(points, mesh, 1.0)
    np.testing.assert_allclose(distance, expected, atol=0.003)


def test_the_command_line_prints_json(tmp_path, truth, monkeypatch, capsys):
    from crispline.cadfile.step import write_step
    from parts.truth import write_truth

    write_step(box(SIZE), tmp_path / "model.step")
    write_truth(tmp_path / "truth.npz", truth, truth.spacing**2 * N_POINTS)
    words = ["referee", str(tmp_path / "model.step"), str(tmp_path / "truth.npz"), "--json"]
    monkeypatch.setattr("sys.argv", words)
    referee.main()
    assert json.loads(capsys.readouterr().out)["edge_f1"] == 1.0
