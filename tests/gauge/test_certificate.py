"""The certificate of a model: points that were measured once are not measured again."""

import numpy as np
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

from crispline.gauge import distance
from crispline.gauge.certificate import certify
from crispline.gauge.distance import Gauge, deviations

SPACING = 0.1


def test_only_points_that_are_new_are_measured(monkeypatch):
    rng = np.random.default_rng(0)
    box = BRepPrimAPI_MakeBox(2.0, 1.5, 1.0).Shape()
    cloud = rng.uniform(-0.2, 2.2, (500, 3))
    made = certify(box, cloud, SPACING, 0.01)
    new = rng.uniform(-0.5, 2.5, (40, 3))
    asked = []

    measured = Gauge.deviations

    def counted(gauge, points):
        asked.append(len(points))
        return measured(gauge, points)

    monkeypatch.setattr(Gauge, "deviations", counted)
    monkeypatch.setattr(distance, "_target", None)  # nor is the shape made ready again
    mixed = rng.permutation(np.concatenate([cloud + 1e-9, new, cloud[:30]]))
    found = made.deviations(mixed)
    assert asked == [40]
    monkeypatch.undo()
    expected = deviations(box, mixed, SPACING)
    np.testing.assert_allclose(found.distance, expected.distance, atol=1e-8)
    np.testing.assert_allclose(found.foot, expected.foot, atol=1e-8)
    np.testing.assert_array_equal(found.face, expected.face)
    monkeypatch.setattr(Gauge, "deviations", counted)
    made.deviations(cloud)
    assert asked == [40]


def test_the_numbers_are_those_of_the_points():
    box = BRepPrimAPI_MakeBox(2.0, 1.5, 1.0).Shape()
    points = np.array([[1.0, 0.7, 1.01], [1.0, 0.7, 0.98], [1.0, 0.7, -0.03]])
    made = certify(box, points, SPACING, 0.005)
    np.testing.assert_allclose(made.found.distance, [0.01, -0.02, 0.03], atol=1e-9)
    assert made.whole.n_points == 3
    assert made.whole.explained == 1.0 / 3.0
    assert sorted(face.n_points for face in made.faces) == [0, 0, 0, 0, 1, 2]
