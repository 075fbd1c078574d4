"""Signs of smooth pieces: faces turned the wrong way are turned back."""

import numpy as np
import pytest

from crispline.cloud.normals import principal_normals
from crispline.cloud.working import working_cloud
from crispline.net import signs
from crispline.net.orientation import indicator_spread, oriented_normals
from crispline.net.poisson import point_areas
from crispline.net.signs import with_best_signs
from crispline.options import CloudOptions, NetOptions


def sampled_box(n, rng):
    """Points and outward normals of a box of 3 x 2 x 1."""
    size = np.array([3.0, 2.0, 1.0])
    points, normals = [], []
    for axis in range(3):
        area = size.prod() / size[axis]
        for side in (0.0, 1.0):
            face = rng.uniform(size=(round(n * area / 22.0), 3)) * size
            face[:, axis] = side * size[axis]
            points.append(face)
            normals.append(np.tile((2.0 * side - 1.0) * np.eye(3)[axis], (len(face), 1)))
    return np.concatenate(points), np.concatenate(normals)


def flared_cup(n, rng):
    """Points and outward normals of a frustum whose wall and top meet at 40 degrees."""
    low, high, height = 0.4, 1.6, 1.0
    slant = np.hypot(high - low, height)
    areas = np.array([low**2, high**2, (low + high) * slant])
    n_low, n_high, n_wall = np.round(n * areas / areas.sum()).astype(int)
    share = rng.uniform(size=n_wall)
    rise = (np.sqrt(low**2 + share * (high**2 - low**2)) - low) / (high - low)
    turn = rng.uniform(0.0, 2.0 * np.pi, n_wall)
    spoke = np.column_stack([np.cos(turn), np.sin(turn)])
    wall = np.column_stack([(low + rise * (high - low))[:, None] * spoke, height * rise])
    leaning = np.column_stack([height * spoke, np.full(n_wall, low - high)]) / slant
    discs = []
    for count, radius, z in ((n_low, low, 0.0), (n_high, high, height)):
        turn, away = rng.uniform(0.0, 2.0 * np.pi, count), radius * np.sqrt(rng.uniform(size=count))
        discs.append(np.column_stack([away * np.cos(turn), away * np.sin(turn), np.full(count, z)]))
    points = np.concatenate([wall, *discs])
    ends = [
        np.tile([0.0, 0.0, side], (len(disc), 1)) for side, disc in zip((-1, 1), discs, strict=True)
    ]
    return points, np.concatenate([leaning, *ends])


@pytest.mark.parametrize("seed", range(5))
def test_faces_of_a_box_turned_at_random_come_out_outward(seed):
    rng = np.random.default_rng(seed)
    cloud = working_cloud(sampled_box(4000, rng)[0], CloudOptions())
    given, truth = sampled_box(4000, np.random.default_rng(seed))
    _, order = np.unique(given, axis=0, return_index=True)
    truth = (truth @ axes(cloud))[np.sort(order)]
    face = np.round(truth @ [1.0, 2.0, 4.0], 3)
    turned = truth.copy()
    for name in np.unique(face):
        turned[face == name] *= rng.choice([-1.0, 1.0])
    found = with_best_signs(cloud.points, turned, cloud.neighbours, point_areas(cloud.distances))
    assert np.mean(np.einsum("ij,ij->i", found, truth) > 0.0) > 0.999


def test_pieces_that_turn_round_are_not_worked_out_again(monkeypatch):
    cloud = working_cloud(sampled_box(4000, np.random.default_rng(0))[0], CloudOptions())
    normals = principal_normals(cloud.points, cloud.neighbours, 18)
    areas = point_areas(cloud.distances)
    middle = cloud.points.mean(axis=0)
    outward = np.einsum("ij,ij->i", normals, cloud.points - middle) > 0.0
    normals = np.where(outward, 1.0, -1.0)[:, None] * normals
    is_low = cloud.points[:, :1] < cloud.points[:, :1].min() + 1.0
    made, known = [], []
    work = signs._couplings
    monkeypatch.setattr(signs, "_couplings", lambda *of: made.append(1) or work(*of))
    for turn in (np.ones_like(is_low, float), np.where(is_low, -1.0, 1.0)):
        turned = turn * normals
        found = with_best_signs(cloud.points, turned, cloud.neighbours, areas, known=known)
        alone = with_best_signs(cloud.points, turned, cloud.neighbours, areas)
        np.testing.assert_array_equal(found, alone)
    assert len(made) == 3  # once with what was known, twice without
    noisy = np.where(np.arange(len(normals)) % 9 == 0, -1.0, 1.0)[:, None] * normals
    with_best_signs(cloud.points, noisy, cloud.neighbours, areas, known=known)
    assert len(known) == 2  # single points have turned: that is another field


def test_a_cup_with_an_acute_rim_is_oriented():
    points, truth = flared_cup(8000, np.random.default_rng(1))
    cloud = working_cloud(points, CloudOptions())
    found = oriented_normals(cloud, NetOptions())
    assert found.spread < NetOptions().good_spread
    is_right = np.einsum("ij,ij->i", found.normals, truth @ axes(cloud)) > 0.0
    from_rim = np.hypot(np.hypot(*points[:, :2].T) - 1.6, points[:, 2] - 1.0) / cloud.spacing
    assert is_right[from_rim > 3.0].all()


def test_the_spread_never_grows():
    points, _ = flared_cup(3000, np.random.default_rng(2))
    cloud = working_cloud(points, CloudOptions())
    areas = point_areas(cloud.distances)
    normals = principal_normals(cloud.points, cloud.neighbours, 18)
    normals *= np.sign(np.einsum("ij,j->i", normals, [0.3, 0.5, 0.8]))[:, None]
    better = with_best_signs(cloud.points, normals, cloud.neighbours, areas)
    before, after = (indicator_spread(cloud.points, n, areas) for n in (normals, better))
    assert after < before


def test_one_smooth_piece_stays_as_it_is():
    points = np.random.default_rng(0).normal(size=(3000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    cloud = working_cloud(points, CloudOptions())
    normals = cloud.points / np.linalg.norm(cloud.points, axis=1, keepdims=True)
    found = with_best_signs(cloud.points, normals, cloud.neighbours, point_areas(cloud.distances))
    np.testing.assert_array_equal(found, normals)


def axes(cloud):
    """Maps directions of the given frame, as rows, to the working frame."""
    unit_steps = cloud.to_user.points(np.eye(3)) - cloud.to_user.points(np.zeros((3, 3)))
    return (unit_steps / cloud.spacing).T
