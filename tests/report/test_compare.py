"""Any model against any cloud: numbers by hand, JSON, tables, the command."""

import io
import json

import numpy as np
import pytest
from click.testing import CliRunner
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from rich.console import Console

from crispline.cadfile.shape_files import write_shape
from crispline.cli import main
from crispline.gauge.comparison import compare
from crispline.report.compare import comparison_summary, render_comparison

BOX = BRepPrimAPI_MakeBox(40.0, 30.0, 20.0).Shape()


def cloud(n=4000, noise=0.05):
    """The top of the box, noisy; a patch of its side at x = 40, 0.5 off; one stray point."""
    stream = np.random.default_rng(3)
    top = stream.uniform([1, 1, 20], [39, 29, 20], (n, 3))
    top[:, 2] += noise * stream.normal(size=n)
    side = stream.uniform([40.5, 5, 5], [40.5, 15, 15], (n // 8, 3))
    return np.vstack([top, side, [[20.0, 15.0, 26.0]]])


def test_the_numbers_are_those_of_the_box():
    points = cloud()
    found = compare(BOX, points, tolerance=0.2)
    by_points = sorted((f.residuals.n_points, i) for i, f in enumerate(found.faces))
    assert [n for n, _ in by_points] == [0, 0, 0, 0, 500, 4001]
    side, top = (found.faces[i].residuals for _, i in by_points[-2:])
    assert [side.rms, side.p95, side.max, side.mean] == pytest.approx([0.5] * 4)
    assert top.rms == pytest.approx(np.sqrt((4000 * 0.05**2 + 36.0) / 4001), rel=0.05)
    assert top.max == pytest.approx(6.0)
    assert (side.explained, top.explained) == (0.0, pytest.approx(1.0, abs=1e-3))
    assert found.worst_face == by_points[-2][1]
    assert found.is_within is False
    assert compare(BOX, points, tolerance=0.51).is_within is True
    assert found.noise == pytest.approx(0.05, rel=0.1)
    assert found.counts.sum() == len(points)
    # The middle of the histogram against a count.
    inner = np.abs(found.bin_edges) < 0.3
    low, high = found.bin_edges[inner][[0, -1]]
    expected = np.count_nonzero((found.found.distance >= low) & (found.found.distance < high))
    assert found.counts[np.flatnonzero(inner)[:-1]].sum() == expected
    assert found.warnings == ()


def test_without_a_tolerance_the_noise_sets_the_share():
    found = compare(BOX, cloud())
    assert (found.tolerance, found.is_within) == (None, None)
    assert found.limit == pytest.approx(3.0 * found.noise)
    assert "within 3 sigma" in found.verdict


def test_a_few_points_are_enough():
    found = compare(BOX, np.array([[20.0, 15.0, 20.3], [20.0, -0.1, 10.0]]))
    assert (found.whole.n_points, found.whole.max) == (2, pytest.approx(0.3))
    assert np.isnan(found.limit)
    content = comparison_summary(found, "mm")
    assert (content["noise"], content["overall"]["explained"]) == (None, None)
    json.dumps(content, allow_nan=False)


def test_another_frame_is_told():
    (warning,) = compare(BOX, cloud() + 100.0).warnings
    assert "another unit (see --units) or another frame" in warning


def test_tables_and_json_say_the_same():
    found = compare(BRepPrimAPI_MakeCylinder(10.0, 30.0).Shape(), cloud(800) / 4.0, 2.0)
    content = json.loads(json.dumps(comparison_summary(found, "mm"), allow_nan=False))
    assert {face["kind"] for face in content["faces"]} == {"plane", "cylinder"}
    assert sum(face["n_points"] for face in content["faces"]) == content["overall"]["n_points"]
    assert len(content["histogram"]["edges"]) == len(content["histogram"]["counts"]) + 1
    console = Console(file=io.StringIO(), width=140)
    console.print(render_comparison(found, "mm"))
    text = console.file.getvalue()
    for part in (found.verdict, "901 points in mm", "cylinder", "within"):
        assert part in text


@pytest.fixture
def files(tmp_path):
    write_shape(BOX, tmp_path / "box.step", "mm")
    np.save(tmp_path / "cloud.npy", cloud())
    return tmp_path


def run(*arguments):
    return CliRunner().invoke(main, ["compare", *map(str, arguments)])


def test_the_command_measures_and_judges(files):
    out = files / "out.json"
    good = run(files / "box.step", files / "cloud.npy", "--tolerance", 0.6, "--json", out)
    assert good.exit_code == 0, good.output
    assert json.loads(out.read_text())["is_within_tolerance"] is True
    bad = run(files / "box.step", files / "cloud.npy", "--tolerance", 0.2, "--json", out)
    assert bad.exit_code == 3
    assert "misses the tolerance of 0.2 mm" in bad.output
    assert json.loads(out.read_text())["is_within_tolerance"] is False


def test_the_unit_of_the_cloud_may_be_another(files):
    np.save(files / "metres.npy", cloud() / 1000.0)
    out = files / "out.json"
    assert (
        run(files / "box.step", files / "metres.npy", "--units", "m", "--json", out).exit_code == 0
    )
    found = json.loads(out.read_text())
    assert found["unit"] == "mm"
    assert found["overall"]["max"] == pytest.approx(6.0)


def test_the_command_writes_a_page(files):
    page = files / "page.html"
    assert run(files / "box.step", files / "cloud.npy", "--report", page).exit_code == 0
    text = page.read_text(encoding="utf-8")
    assert "box.step and cloud.npy" in text
    assert "nan" not in text.split("<script")[0].lower()


def test_bad_files_are_told(files):
    missing = run(files / "no.step", files / "cloud.npy")
    assert (missing.exit_code, "no such file" in missing.output) == (2, True)
    (files / "bad.step").write_text("nonsense")
    broken = run(files / "bad.step", files / "cloud.npy")
    assert (broken.exit_code, "expected a STEP file" in broken.output) == (2, True)
