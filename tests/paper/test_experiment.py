import pytest

from crispline.errors import InputError
from crispline.paper.experiment import Plan, run


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"methods": ()}, "methods: expected at least one"),
        ({"methods": ("paper", "magic")}, "method: expected one of published, .* got 'magic'"),
        ({"methods": ("paper", "paper")}, "methods: expected each once"),
        ({"phases": (0.0, 0.7)}, "phase: expected a position of 0 to 0.5"),
        ({"phases": (float("nan"),)}, "phase: expected a position"),
        ({"noise_levels": (-0.01,)}, "noise level: expected a fraction"),
        ({"noise_levels": (float("inf"),)}, "noise level: expected a fraction"),
        ({"n_seeds": 0}, "seeds: expected 1 or more"),
    ],
)
def test_a_plan_that_cannot_be_run_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        Plan(**changes)


def test_published_numbers_need_no_run():
    plan = Plan(methods=("published",))
    assert list(plan.runs()) == []
    assert len(run(plan)) == 16


def test_without_noise_a_grid_is_run_once():
    plan = Plan(methods=("robust",), phases=(0.25,), noise_levels=(0.0, 0.01), n_seeds=3)
    seeds = [(each.noise, each.seed) for each in plan.runs() if each.feature == "corner"]
    assert seeds == [(0.0, 0), (0.01, 0), (0.01, 1), (0.01, 2)]


def test_whole_clouds_have_seeds_of_their_own():
    plan = Plan(methods=("pipeline",), noise_levels=(0.0, 0.02), n_seeds=5, n_whole_seeds=2)
    kinds = [(each.sampling, each.noise) for each in plan.runs()]
    assert kinds.count(("grid", 0.0)) == 1
    assert kinds.count(("random", 0.0)) == 2
    assert kinds.count(("half-cell", 0.02)) == 2
