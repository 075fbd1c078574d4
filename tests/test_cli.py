"""The command line against a stand-in pipeline; the real one is run in ``TestWholeChain``."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import crispline
from crispline import cli, shapes
from crispline.cadfile.units import MILLIMETRES
from crispline.cloud.read import read_points
from crispline.cloud.write import WRITE_SUFFIXES
from crispline.curve import Line
from crispline.errors import InputError, ReconstructionError
from crispline.exchange.edges import EDGE_SUFFIXES, write_edges
from crispline.exchange.models import MODEL_SUFFIXES, SHAPE_SUFFIXES
from crispline.exchange.write import WRITE_SUFFIXES as SURFACE_SUFFIXES
from crispline.files import write_text


def run(*arguments):
    return CliRunner().invoke(cli.main, [str(argument) for argument in arguments])


def one_error(outcome) -> str:
    """The message of a failed run; there must be exactly one, and no traceback."""
    assert outcome.exception is None or isinstance(outcome.exception, SystemExit)
    lines = [line for line in outcome.stderr.splitlines() if line.startswith("Error: ")]
    assert len(lines) == 1
    assert "Traceback" not in outcome.output
    return lines[0]


# --- a stand-in for the pipeline ----------------------------------------------------------


SPAN = Line(np.zeros(3), np.array([1.0, 0.0, 0.0]), 0.0, 5.0)


@dataclass
class FakeResult:
    valid: bool = True
    spacing: float = 1.0
    noise: float = 0.1
    edges: tuple = (
        SimpleNamespace(curve=SPAN, points=SPAN.samples(2), angle_deg=90.0, is_sharp=True),
        SimpleNamespace(curve=SPAN, points=SPAN.samples(2), angle_deg=2.0, is_sharp=False),
    )
    corners: np.ndarray = field(default_factory=lambda: np.zeros((1, 3)))

    def summary(self):
        return {
            "valid": self.valid,
            "closed": True,
            "n_faces": 0,
            "faces": [],
            "edges": [],
            "corners": [],
            "noise": self.noise,
            "spacing": self.spacing,
            "timings": {"net": 1.0},
            "warnings": [],
        }

    def write(self, path: Path, unit: str, tolerance: float | None):
        if not self.valid:
            raise ReconstructionError("the shell is open at region 3")
        write_text(path, f"{path.suffix} {unit} {tolerance}")

    def require(self, tolerance: float):
        if tolerance < 0.5:
            raise ReconstructionError(f"face 3 misses the tolerance of {tolerance:g}", self)

    def write_edges(self, path: Path, unit: str):
        sharp = [edge for edge in self.edges if edge.is_sharp]
        write_edges(path, sharp, self.corners, spacing=1.0, noise=0.1, unit=unit)


class FakePipeline(ModuleType):
    def __init__(self):
        super().__init__("crispline.pipeline")
        self.outcome = FakeResult()
        self.calls = []

    def reconstruct(self, cloud, options, progress):
        self.calls.append((cloud, options))
        progress("net", 0.1)
        if isinstance(self.outcome, BaseException):
            raise self.outcome
        return self.outcome

    detect = reconstruct


@pytest.fixture
def pipeline(monkeypatch):
    fake = FakePipeline()
    monkeypatch.setitem(sys.modules, "crispline.pipeline", fake)
    monkeypatch.setattr(crispline, "pipeline", fake, raising=False)
    return fake


@pytest.fixture
def cloud(tmp_path):
    path = tmp_path / "cloud.npy"
    np.save(path, np.random.default_rng(0).normal(size=(50, 3)))
    return path


# --- help and imports ---------------------------------------------------------------------


@pytest.mark.parametrize("command", [(), *((name,) for name in sorted(cli.main.commands))])
def test_help(command):
    outcome = run(*command, "--help")
    assert outcome.exit_code == 0
    assert "Usage: " in outcome.output


def test_help_and_import_load_nothing_heavy():
    script = (
        "import sys, crispline, crispline.cli\n"
        "heavy = {'numpy', 'scipy', 'rich', 'OCP', 'trimesh'} & set(sys.modules)\n"
        "raise SystemExit(', '.join(heavy) or 0)"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_names_repeated_for_a_fast_help_are_the_real_ones():
    assert set(cli.experiments.SHAPES) == set(shapes.SHAPES)
    assert cli.experiments.SAMPLINGS == shapes.SAMPLINGS
    assert cli.experiments.CLOUDS_OUT == WRITE_SUFFIXES
    assert cli.clouds.EDGES_OUT == EDGE_SUFFIXES
    assert set(cli.clouds.MODELS_OUT) == set(MODEL_SUFFIXES)
    assert set(cli.convert.MODELS_IN) == set(SHAPE_SUFFIXES)
    assert set(cli.parameters.UNITS) == set(MILLIMETRES)
    assert cli.surfaces.SURFACES_OUT == SURFACE_SUFFIXES


def test_the_package_offers_its_names_lazily():
    assert crispline.PointCloud is crispline.read_points.__globals__["PointCloud"]
    assert set(crispline.__all__) <= set(dir(crispline))
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        crispline.nonsense  # noqa: B018


# --- sample -------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", cli.experiments.SHAPES)
def test_sample_writes_cloud_and_truth(tmp_path, shape):
    outcome = run(
        "sample", shape, "--points", 2000, "--noise", "2%", "--outliers", 0.1, "--seed", 3,
        "-o", tmp_path / "cloud.ply", "--truth", tmp_path / "truth.npz",
    )  # fmt: skip
    assert outcome.exit_code == 0, outcome.output
    points = read_points(tmp_path / "cloud.ply").points
    expected = shapes.sample(shapes.SHAPES[shape](), 2000, noise=0.02, outliers=0.1, seed=3)
    np.testing.assert_allclose(points, expected.points, atol=1e-5)
    with np.load(tmp_path / "truth.npz") as truth:
        np.testing.assert_array_equal(truth["points"], expected.clean)


def test_sample_twice_gives_the_same_bytes(tmp_path):
    for name in ("a.ply", "b.ply"):
        run("sample", "bracket", "--points", 500, "--noise", 0.01, "-o", tmp_path / name)
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


def test_the_bundled_scan_is_the_one_that_the_command_makes(tmp_path):
    root = Path(__file__).parents[1]
    recipe = next(
        line for line in (root / "Makefile").read_text().splitlines() if "sample bracket" in line
    )
    arguments = recipe.split("crispline ")[1].split()
    arguments[-1] = tmp_path / "bracket.ply"
    assert run(*arguments).exit_code == 0
    made = read_points(tmp_path / "bracket.ply").points
    bundled = read_points(root / "examples" / "bracket.ply").points
    np.testing.assert_allclose(made, bundled, atol=1e-4)


# --- bad usage: exit 2, before any work ---------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sample", "teapot", "-o", "{}/a.ply"], "teapot"),
        (["sample", "bracket", "-o", "{}/a.docx"], "ends in .csv or .las"),
        (["sample", "bracket"], "Missing option '-o'"),
        (["sample", "bracket", "--noise", "loud", "-o", "{}/a.ply"], "0.02 or 2%, got 'loud'"),
        (["sample", "bracket", "--noise", "-1%", "-o", "{}/a.ply"], "got '-1%'"),
        (["sample", "bracket", "--noise", "nan", "-o", "{}/a.ply"], "got 'nan'"),
        (["sample", "bracket", "--points", "0", "-o", "{}/a.ply"], "--points"),
        (["sample", "bracket", "--truth", "{}/t.txt", "-o", "{}/a.ply"], "ends in .npz"),
        (["sample", "bracket", "-o", "{}/none/a.ply"], "does not exist"),
        (["reconstruct", "{}/cloud.npy"], "Missing option '-o'"),
        (["reconstruct", "-o", "{}/a.step"], "Missing argument 'CLOUD'"),
        (["reconstruct", "{}/cloud.npy", "-o", "{}/a.docx"], "ends in .brep or"),
        (["reconstruct", "{}/cloud.npy", "-o", "{}/none/a.step"], "does not exist"),
        (["reconstruct", "{}/cloud.npy", "-o", "{}/folder.step"], "it is a folder"),
        (
            ["reconstruct", "{}/cloud.npy", "-o", "{}/a.step", "--summary", "{}/s.txt"],
            "ends in .json",
        ),
        (["reconstruct", "{}/cloud.npy", "-o", "{}/a.step", "--seed", "-1"], "--seed"),
        (["reconstruct", "{}/cloud.npy", "-o", "{}/a.step", "--threads", "two"], "--threads"),
        (["detect", "{}/cloud.npy", "-o", "{}/a.ply"], "ends in .dxf or .json or .obj"),
        (["reconstruct", "{}/cloud.npy", "-o", "{}/a.step", "--units", "ell"], "--units"),
        (["detect", "{}/cloud.npy", "-o", "{}/a.json", "--fast"], "--fast"),
    ],
)
def test_bad_usage(tmp_path, pipeline, cloud, arguments, message):
    (tmp_path / "folder.step").mkdir()
    before = sorted(tmp_path.iterdir())
    outcome = run(*(argument.format(tmp_path) for argument in arguments))
    assert outcome.exit_code == 2
    assert message in one_error(outcome)
    assert pipeline.calls == []
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("command", ["reconstruct", "detect"])
@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.ply", None, "no such file"),
        ("empty.xyz", b"", "empty file"),
        ("scan.docx", b"text", "ends in one of"),
        ("letter.ply", b"Dear reader", "expected a PLY file"),
        ("text.xyz", b"1 2 3\n4 five 6\n", "line 2: expected a number, found 'five'"),
        ("nan.xyz", b"nan nan nan\n" * 20, "all NaN or infinite"),
    ],
)
def test_bad_clouds(tmp_path, pipeline, command, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    before = sorted(tmp_path.iterdir())
    output = tmp_path / ("a.step" if command == "reconstruct" else "a.json")
    outcome = run(command, tmp_path / name, "-o", output)
    assert outcome.exit_code == 2
    assert message in one_error(outcome)
    assert pipeline.calls == []
    assert sorted(tmp_path.iterdir()) == before


# --- reconstruct and detect ---------------------------------------------------------------


def test_reconstruct_writes_model_and_summary(tmp_path, pipeline, cloud):
    step, summary = tmp_path / "a.step", tmp_path / "s.json"
    outcome = run("reconstruct", cloud, "-o", step, "--summary", summary, "--seed", 5)
    assert outcome.exit_code == 0, outcome.output
    assert step.exists()
    assert json.loads(summary.read_text()) == FakeResult().summary()
    assert "valid closed solid" in outcome.stdout
    assert "net" in outcome.stderr
    points, options = pipeline.calls[0]
    assert len(points) == 50
    assert options.seed == 5


@pytest.mark.parametrize("partial", [None, FakeResult(valid=False)])
def test_a_failed_reconstruction_still_writes_the_summary(tmp_path, pipeline, cloud, partial):
    pipeline.outcome = ReconstructionError("region 7 cannot be closed; add points", partial)
    step, summary = tmp_path / "a.step", tmp_path / "s.json"
    outcome = run("reconstruct", cloud, "-o", step, "--summary", summary)
    assert outcome.exit_code == 3
    assert one_error(outcome) == "Error: region 7 cannot be closed; add points"
    assert not step.exists()
    content = json.loads(summary.read_text())
    assert content["valid"] is False
    assert content["error"] == "region 7 cannot be closed; add points"
    assert set(FakeResult().summary()) < set(content)


def test_a_model_that_is_not_valid_is_not_written(tmp_path, pipeline, cloud):
    pipeline.outcome = FakeResult(valid=False)
    step, summary = tmp_path / "a.step", tmp_path / "s.json"
    outcome = run("reconstruct", cloud, "-o", step, "--summary", summary)
    assert outcome.exit_code == 3
    assert "open at region 3" in one_error(outcome)
    assert not step.exists()
    assert json.loads(summary.read_text())["noise"] == 0.1


@pytest.mark.parametrize(("tolerance", "code"), [(0.6, 0), (0.1, 3)])
def test_a_model_that_misses_the_tolerance_is_written_all_the_same(
    tmp_path, pipeline, cloud, tolerance, code
):
    step, summary = tmp_path / "a.step", tmp_path / "s.json"
    outcome = run("reconstruct", cloud, "-o", step, "--tolerance", tolerance, "--summary", summary)
    assert outcome.exit_code == code
    assert step.exists()
    assert json.loads(summary.read_text())["valid"] is True
    if code:
        assert one_error(outcome) == "Error: face 3 misses the tolerance of 0.1"


def test_several_outputs_in_the_unit_of_the_cloud(tmp_path, pipeline, cloud):
    files = [tmp_path / f"a{suffix}" for suffix in (".step", ".stl", ".json")]
    outputs = [word for file in files for word in ("-o", file)]
    outcome = run("reconstruct", cloud, *outputs, "--units", "m", "--edges", tmp_path / "e.json")
    assert outcome.exit_code == 0, outcome.output
    assert [file.read_text() for file in files] == [f"{file.suffix} m None" for file in files]
    assert json.loads((tmp_path / "e.json").read_text())["unit"] == "m"


@pytest.mark.parametrize("suffix", EDGE_SUFFIXES)
def test_detect_writes_the_sharp_edges(tmp_path, pipeline, cloud, suffix):
    path = tmp_path / f"e{suffix}"
    outcome = run("detect", cloud, "-o", path)
    assert outcome.exit_code == 0, outcome.output
    assert "sharp edges: 1, corners: 1" in outcome.stdout
    if suffix == ".json":
        assert len(json.loads(path.read_text())["edges"]) == 1


def test_a_failed_detection_writes_what_is_good(tmp_path, pipeline, cloud):
    pipeline.outcome = ReconstructionError("the net is torn", FakeResult(valid=False))
    outcome = run("detect", cloud, "-o", tmp_path / "e.json")
    assert outcome.exit_code == 3
    assert one_error(outcome) == "Error: the net is torn"
    assert (tmp_path / "e.json").exists()
    pipeline.outcome = ReconstructionError("the net is torn")
    outcome = run("detect", cloud, "-o", tmp_path / "f.json")
    assert outcome.exit_code == 3
    assert not (tmp_path / "f.json").exists()


@pytest.mark.parametrize("command", ["reconstruct", "detect"])
def test_input_that_the_pipeline_refuses(tmp_path, pipeline, cloud, command):
    pipeline.outcome = InputError("all points lie on a line")
    output = tmp_path / ("a.step" if command == "reconstruct" else "a.json")
    outcome = run(command, cloud, "-o", output)
    assert outcome.exit_code == 2
    assert one_error(outcome) == "Error: all points lie on a line"
    assert not output.exists()


def test_an_interrupted_run_leaves_no_file(tmp_path, pipeline, cloud):
    pipeline.outcome = KeyboardInterrupt()
    step, summary = tmp_path / "a.step", tmp_path / "s.json"
    outcome = run("reconstruct", cloud, "-o", step, "--summary", summary)
    assert outcome.exit_code == 130
    assert [line for line in outcome.stderr.splitlines() if "Interrupted" in line] == [
        "Interrupted; files that were not finished are not written"
    ]
    assert sorted(tmp_path.iterdir()) == [cloud]


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    path = tmp_path_factory.mktemp("scan") / "box.ply"
    outcome = run(
        "sample", "box-cylinder", "--points", 8000, "--noise", "1%", "--sampling", "random",
        "--outliers", 0.01, "-o", path,
    )  # fmt: skip
    assert outcome.exit_code == 0
    return path


class TestWholeChain:
    """The real pipeline, on a scan small enough for a test."""

    def test_reconstruct(self, tmp_path, scan):
        step, summary = tmp_path / "box.step", tmp_path / "box.json"
        outcome = run("reconstruct", scan, "-o", step, "--summary", summary)
        assert outcome.exit_code == 0, outcome.output
        assert step.read_bytes().startswith(b"ISO-10303-21;")
        content = json.loads(summary.read_text())
        assert (content["valid"], content["closed"], content["n_faces"]) == (True, True, 8)
        assert sum(edge["is_sharp"] for edge in content["edges"]) == 14
        assert len(content["corners"]) == 8
        assert content["timings"]

    def test_detect(self, tmp_path, scan):
        outcome = run("detect", scan, "-o", tmp_path / "edges.json")
        assert outcome.exit_code == 0, outcome.output
        content = json.loads((tmp_path / "edges.json").read_text())
        assert len(content["edges"]) == 14
        assert sum(edge["closed"] for edge in content["edges"]) == 2
        assert len(content["corners"]) == 8

    @pytest.mark.parametrize(
        "points",
        [
            np.zeros((100, 3)),
            np.linspace(0.0, 1.0, 100)[:, None] * [1.0, 2.0, 3.0],
            np.random.default_rng(0).random((100, 3)) * [1.0, 1.0, 0.0],
            np.random.default_rng(0).random((10, 3)),
        ],
        ids=["all equal", "on a line", "in a plane", "too few"],
    )
    def test_clouds_without_a_solid(self, tmp_path, points):
        np.save(tmp_path / "cloud.npy", points)
        outcome = run("reconstruct", tmp_path / "cloud.npy", "-o", tmp_path / "a.step")
        assert outcome.exit_code == 2
        one_error(outcome)
        assert not (tmp_path / "a.step").exists()
