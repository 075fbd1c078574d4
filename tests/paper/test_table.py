import json

import crispline
from crispline.paper.rows import Row, published_rows, rows_of
from crispline.paper.table import to_json, to_markdown

from .test_rows import trial

KEYS = (
    "method",
    "sampling",
    "noise",
    "snr_db",
    "feature",
    "initial",
    "initial_spread",
    "final",
    "final_spread",
    "reduction",
    "reduction_spread",
    "initial_reverse_mean",
    "initial_reverse_p99",
    "reverse_mean",
    "reverse_p99",
    "precision",
    "recall",
    "seeds",
    "windows",
    "failures",
)


def rows_for_a_table():
    trials = [
        trial(seed, 0.3, final, method=method, sampling=sampling, noise=0.02)
        for method, sampling, final in (
            ("paper", "grid 0.00", 0.2),
            ("paper", "grid 0.50", 0.1),
            ("robust", "grid 0.00", 2e-6),
            ("robust", "grid 0.50", 3e-6),
            ("pipeline", "grid 0.50", 0.005),
            ("pipeline", "random", None),
        )
        for seed in (0, 1)
    ]
    return [*published_rows([0.02]), *rows_of(trials)]


def lines_after(markdown, heading, nth=0):
    """Cells of the table below the nth heading of that name, by line."""
    part = markdown.split(f"### {heading}\n")[nth + 1].split("\n#")[0]
    lines = [line for line in part.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_json_is_a_list_of_rows():
    rows = json.loads(to_json(rows_for_a_table()))
    assert len(rows) == 10
    for row in rows:
        assert tuple(row) == KEYS
        assert Row(**row)
    assert rows[-1]["final"] is None


def test_the_first_table_shows_every_method_at_its_worst():
    titles, _, *lines = lines_after(to_markdown(rows_for_a_table()), "Feature error")
    assert titles[3:] == ["published", "`--rule paper`", "`--rule robust`", "pipeline"]
    assert lines[0] == [
        "2 %",
        "34 dB",
        "straight",
        "0.2172 (44.59 %)",
        "0.2000 ± 0.0000 (33.33 %)",
        "3e-06 ± 0.0000 (100.00 %)",
        "0.0050 ± 0.0000 (98.33 %)",
    ]
    assert [line[2] for line in lines] == ["straight", "lower circle", "upper circle", "corner"]
    assert lines[3][4:] == ["-", "-", "-"]


def test_the_second_table_has_a_line_for_every_sampling():
    titles, _, *lines = lines_after(to_markdown(rows_for_a_table()), "Feature error", 1)
    assert titles[:4] == ["noise", "feature", "sampling", "plain"]
    straight = [line for line in lines if line[1] == "straight"]
    assert [line[2] for line in straight] == ["grid 0.00", "grid 0.50", "random"]
    assert straight[0][3] == "0.3000"
    assert straight[0][4] == straight[2][4] == "0.2172 (44.59 %)"
    assert straight[0][7] == straight[2][7] == "-"


def test_detection_rounds_down():
    (row,) = rows_of([trial(0, 0.3, 0.1)])
    for share, shown in ((1.0, "100 %"), (0.99999, "99.99 %"), (0.5, "50.00 %")):
        changed = Row(**(row.as_json() | {"precision": share, "recall": None}))
        _, _, line = lines_after(to_markdown([changed]), "Detection of sharp patches")
        assert line[-1] == f"{shown} / -"


def test_the_settings_are_told():
    head = to_markdown(rows_for_a_table()).split("##")[0]
    assert f"version {crispline.__version__}" in head
    assert "`--rule robust`: 2 seeds." in head
    assert "published" not in head


def test_refusals_are_listed():
    assert to_markdown(published_rows([0.02])).endswith("## Refusals\n\nNone.\n")
    failed = rows_of([trial(0, 0.3, None, n_failed=1, n_windows=1)])
    last = to_markdown(failed).splitlines()[-1]
    assert last == "| `--rule robust` | 1 % | straight | grid 0.25 | 1 | 1 |"
