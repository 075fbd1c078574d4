"""The parts of the benchmark are the solids that their functions describe."""

import numpy as np
import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from crispline import occt
from crispline.occt.measure import face_areas, volume
from parts.catalogue import PARTS

VOLUMES = {
    "pocket-block": 80 * 60 * 30 - 26 * 20 * 14 - 18 * 34 * 9 - 12 * 60 * 10 - 80 * 8 * 8,
    "thin-box": 60 * 45 * 25 - 56 * 41 * 23,
    "two-bodies": 40 * 40 * 25 - 20 * 40 * 12 + np.pi * (18**2 - 8**2) * 20,
    "rounded-box": (
        50 * 35 * 20
        + 2 * 5 * (50 * 35 + 35 * 20 + 20 * 50)
        + np.pi * 5**2 * (50 + 35 + 20)
        + 4 / 3 * np.pi * 5**3
    ),
    "sheet-channel": (
        90 * (3 * (30 + 40 + 30) + np.pi / 2 * (5**2 - 2**2))
        - 2 * 3 * (12 * 8 + np.pi * 4**2)
        - 4 * 3 * np.pi * 4**2
    ),
    "low-pads": (
        90 * 60 * 12
        + 26 * 20 * 1.2
        + (26 * 18 - (4 - np.pi) * 5**2) * 2.2
        - (38 * 18 + 16 * 10) * 1.1
        - np.pi * 6**2 * 1.0
    ),
    "flange": np.pi * (40**2 * 10 + 20**2 * 20 - 12**2 * 30 - 6 * 4**2 * 10),
    "fading-crease": 80 * 50 * 30 - 0.6 * 56 / 3 * 30**2 / 2,
    "elbow": (
        np.pi * (12**2 - 7**2) * (28 + 28 + np.pi / 2 * 30) + 2 * np.pi * (22**2 - 12**2) * 8
    ),
}
OPEN = {"bent-sheet"}


@pytest.fixture(scope="module")
def shapes():
    return {name: make() for name, make in PARTS.items()}


def test_there_are_at_least_ten_each_with_a_description():
    assert len(PARTS) >= 10
    assert all(make.__doc__ for make in PARTS.values())


def test_every_part_is_sound(shapes):
    for name, shape in shapes.items():
        assert BRepCheck_Analyzer(shape).IsValid(), name
        n_solids = len(occt.subshapes(shape, occt.SOLID))
        assert n_solids == (0 if name in OPEN else 2 if name == "two-bodies" else 1), name
        assert min(face_areas(shape)) > 1.0, name  # no slivers


@pytest.mark.parametrize("name", VOLUMES)
def test_volume(shapes, name):
    assert volume(shapes[name]) == pytest.approx(VOLUMES[name], rel=1e-6)


def test_the_same_part_each_time(shapes):
    for name in ("draft-pocket", "variable-fillet"):
        assert occt.to_text(PARTS[name]()) == occt.to_text(shapes[name])
