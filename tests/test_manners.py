"""How commands behave: help, settings, what is told and in which form, Ctrl-C and SIGTERM."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from types import ModuleType

import click
import numpy as np
import pytest
from click.testing import CliRunner

import crispline
from crispline import cli, shapes
from crispline.cli.options import configuration
from crispline.configuration import settings, to_toml
from crispline.errors import InputError, ReconstructionError
from crispline.files import atomic_path
from crispline.options import FitOptions, NetOptions, Options, SharpenOptions

ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
COMMANDS = sorted(cli.main.commands)


def run(*arguments):
    return CliRunner().invoke(cli.main, [str(argument) for argument in arguments])


def events(outcome):
    return [json.loads(line) for line in outcome.stderr.splitlines()]


class _Found:
    """What a run leaves, as far as `detect` looks at it."""

    edges = ()
    corners = np.zeros((0, 3))

    def summary(self):
        return {"n_faces": 3}

    def write_edges(self, path, unit):
        path.write_text(unit)


@pytest.fixture
def detect(monkeypatch, tmp_path):
    """Runs `detect` with a pipeline that tells three stages and ends as it is told to."""
    cloud = tmp_path / "cloud.npy"
    np.save(cloud, np.random.default_rng(0).normal(size=(50, 3)))

    def run_detect(*arguments, ending=None, before=()):
        seen = []

        def stand_in(points, options, progress):
            seen.append(options)
            for stage, share in (("cloud", 0.0), ("net", 0.25), ("net", 0.5)):
                progress(stage, share)
            if ending is not None:
                raise ending
            return _Found()

        fake = ModuleType("crispline.pipeline")
        fake.detect = stand_in
        monkeypatch.setitem(sys.modules, "crispline.pipeline", fake)
        monkeypatch.setattr(crispline, "pipeline", fake, raising=False)
        outcome = run(*before, "detect", cloud, "-o", tmp_path / "edges.json", *arguments)
        return outcome, seen[0] if seen else None

    return run_detect


# --- help ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMMANDS)
def test_help_ends_with_an_example_that_is_good_usage(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = cli.main.commands[name]
    assert command.epilog.startswith(f"Example: crispline {name} ")
    for example in command.epilog.removeprefix("Example: crispline ").split(", crispline "):
        with cli.main.make_context("crispline", shlex.split(example)) as context:
            words = context._protected_args + context.args
            assert words[0] == name
            command.make_context(name, words[1:], parent=context)


@pytest.mark.skipif(sys.platform == "win32", reason="the time of a child is not known")
def test_help_takes_less_than_half_a_second():
    import resource

    def seconds():
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, "-m", "crispline", "--help"],
            env=ENVIRONMENT,
            capture_output=True,
            check=True,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    assert min(seconds() for _ in range(3)) < 0.5


def test_the_shell_completes_commands_and_options():
    def completed(*words):
        environment = {
            **ENVIRONMENT,
            "_CRISPLINE_COMPLETE": "bash_complete",
            "COMP_WORDS": " ".join(words),
            "COMP_CWORD": str(len(words) - 1),
        }
        script = "import sys; sys.argv[0] = 'crispline'\nfrom crispline.cli import main; main()"
        done = subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True
        )
        return {line.partition(",")[2] for line in done.stdout.splitlines()}

    assert completed("crispline", "re") == {"reconstruct"}
    assert completed("crispline", "reconstruct", "--regu") == {"--regularize"}
    assert completed("crispline", "reconstruct", "--model", "p") == {"patches"}


# --- settings -----------------------------------------------------------------------------


@pytest.mark.parametrize("command", [(), ("reconstruct",), ("detect",), ("sharpen",)])
def test_dump_options_prints_the_defaults(command):
    outcome = run(*command, "--dump-options")
    assert outcome.exit_code == 0
    assert outcome.stdout == to_toml()


def test_without_a_word_the_defaults_hold(detect):
    assert detect()[1] == Options()


def test_the_command_line_counts_more_than_the_file(detect, tmp_path):
    path = tmp_path / "run.toml"
    path.write_text("seed = 4\nthreads = 1\n[net]\nfill_holes = 9\nsurface = 'open'\n")
    assert detect("--config", path)[1] == Options(
        seed=4, threads=1, net=NetOptions(fill_holes=9.0, surface="open")
    )
    outcome, options = detect(
        "--config", path, "--seed", 0, "--closed", "--fill-holes", 3, "--no-regularize"
    )
    assert outcome.exit_code == 0
    assert options == Options(
        threads=1,
        net=NetOptions(fill_holes=3.0, surface="closed"),
        fit=FitOptions(regularize=False),
    )


def test_a_bad_file_of_settings_is_told_before_the_run(detect, tmp_path):
    path = tmp_path / "run.toml"
    path.write_text("[net]\nfill_hole = 9\n")
    outcome, options = detect("--config", path)
    assert (outcome.exit_code, options) == (2, None)
    assert outcome.stderr == (
        f"Error: '{path}': unknown key 'net.fill_hole'; did you mean 'net.fill_holes'?\n"
    )
    with pytest.raises(InputError, match="cannot be read: No such file"):
        configuration(tmp_path / "none.toml")


def test_sharpen_takes_its_table(tmp_path, monkeypatch):
    import crispline.grid

    seen = []

    def stand_in(points, options):
        seen.append(options)
        raise InputError("enough seen")

    monkeypatch.setattr(crispline.grid, "sharpen", stand_in)
    steps = np.arange(6.0)
    np.save(tmp_path / "g.npy", np.stack(np.meshgrid(steps, steps, [0.0])[:3], -1)[:, :, 0])
    path = tmp_path / "run.toml"
    path.write_text("[sharpen]\nrule = 'paper'\nrepeat = 2\nmax_gap = 0.5\n")
    outcome = run(
        "sharpen", tmp_path / "g.npy", "-o", tmp_path / "s.npz", "--config", path, "--repeat", 1
    )
    assert "enough seen" in outcome.stderr
    assert seen == [SharpenOptions(rule="paper", repeat=1, max_gap=0.5)]


def test_the_defaults_in_the_help_are_the_real_ones():
    names = {
        "seed": "seed",
        "threads": "threads",
        "model": "model",
        "fill_holes": "net.fill_holes",
        "normals": "net.normals",
        "rule": "sharpen.rule",
        "repeat": "sharpen.repeat",
    }
    real = {one.name: one.value for one in settings()}
    told = {
        one.name: re.search(r"\[default: (.+)\]", one.help)[1]
        for command in ("reconstruct", "sharpen")
        for one in cli.main.commands[command].params
        if one.name in names
    }
    assert told == {name: str(real[path]) for name, path in names.items()}


# --- what is told -------------------------------------------------------------------------


def test_in_a_pipe_every_stage_is_a_plain_line(detect):
    outcome, _ = detect()
    assert outcome.stderr.split("\n") == ["  0%  cloud", " 25%  net", ""]
    assert "sharp edges: 0" in outcome.stdout


@pytest.mark.parametrize("place", ["before", "after"])
def test_quiet_tells_nothing(detect, place):
    outcome, _ = detect(before=["--quiet"]) if place == "before" else detect("-q")
    assert (outcome.exit_code, outcome.output) == (0, "")


@pytest.mark.parametrize(
    ("ending", "code"), [(ReconstructionError("no luck"), 3), (InputError("no luck"), 2)]
)
def test_quiet_tells_errors(detect, ending, code):
    outcome, _ = detect("--quiet", ending=ending)
    assert (outcome.exit_code, outcome.output) == (code, "Error: no luck\n")


def test_quiet_silences_other_commands_too(tmp_path):
    outcome = run("sample", "bracket", "--points", 500, "-o", tmp_path / "a.ply", "--quiet")
    assert (outcome.exit_code, outcome.output) == (0, "")
    assert (tmp_path / "a.ply").exists()


def test_verbose_tells_versions_settings_and_seconds(detect):
    outcome, _ = detect("--verbose", "--seed", 3)
    head, others, *stages = outcome.stderr.splitlines()
    assert f"numpy {np.__version__}" in head
    assert others == "settings other than the defaults: seed = 3"
    assert [line.split()[0] for line in stages] == ["0%", "25%", "50%"]
    assert all(float(line.split()[1]) < 60.0 for line in stages)


def test_verbose_tells_where_a_defect_is(detect):
    defect = ZeroDivisionError("by naught")
    outcome, _ = detect(ending=defect)
    assert outcome.exit_code == 1
    assert "Error: ZeroDivisionError: by naught; this is a defect" in outcome.stderr
    assert "Traceback" not in outcome.output
    outcome, _ = detect("-v", ending=defect)
    assert "in stand_in" in outcome.stderr


def test_quiet_and_verbose_exclude_each_other(detect):
    for before, after in (([], ["-q", "-v"]), (["-q"], ["-v"])):
        outcome, _ = detect(*after, before=before)
        assert outcome.exit_code == 2
        assert "expected one of them, got both" in outcome.stderr


def test_log_json_is_one_object_a_line(detect):
    outcome, _ = detect("--log-json")
    *stages, last = events(outcome)
    assert [(one["event"], one["stage"], one["share"]) for one in stages] == [
        ("stage", "cloud", 0.0),
        ("stage", "net", 0.25),
        ("stage", "net", 0.5),
    ]
    times = [one["seconds"] for one in [*stages, last]]
    assert times == sorted(times)
    assert (last["event"], last["exit_code"], last["summary"]) == ("result", 0, {"n_faces": 3})


@pytest.mark.parametrize(
    ("ending", "code", "message"),
    [
        (ReconstructionError("no luck"), 3, "no luck"),
        (KeyboardInterrupt(), 130, "Interrupted; files that were not finished are not written"),
        (TypeError("odd"), 1, "TypeError: odd"),
    ],
)
def test_log_json_ends_with_the_error(detect, ending, code, message):
    outcome, _ = detect("--log-json", ending=ending)
    last = events(outcome)[-1]
    assert outcome.exit_code == code
    assert (last["event"], last["exit_code"]) == ("error", code)
    assert last["message"].startswith(message)


def test_log_json_tells_bad_usage_in_its_form(detect):
    outcome, _ = detect("--seed", "x", "--log-json")
    assert outcome.exit_code == 2
    (only,) = events(outcome)
    assert "--seed" in only["message"]


# --- Ctrl-C, SIGTERM ---------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="Windows ends a process without a word")
def test_termination_while_a_file_is_written_leaves_nothing(detect, monkeypatch, tmp_path):
    def write(self, path, unit):
        with atomic_path(path) as draft:
            draft.write_text("half of it")
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(5.0)  # the signal arrives before that

    monkeypatch.setattr(_Found, "write_edges", write)
    before = signal.getsignal(signal.SIGTERM)
    outcome, _ = detect()
    assert outcome.exit_code == 143
    assert outcome.stderr.splitlines()[-1] == (
        "Terminated; files that were not finished are not written"
    )
    assert [one.name for one in tmp_path.iterdir()] == ["cloud.npy"]
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one child alone")
def test_ctrl_c_leaves_nothing_half_written(tmp_path):
    cloud = tmp_path / "box.npy"
    np.save(cloud, shapes.sample(shapes.SHAPES["box-cylinder"](), 5000, noise=0.01).points)
    (tmp_path / "old.step").write_text("as it was")
    arguments = ["reconstruct", cloud, "-o", tmp_path / "old.step", "-o", tmp_path / "new.stl"]
    # A job in the background of a shell ignores Ctrl-C, and so would the child: it is to heed it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        child = subprocess.Popen(
            [sys.executable, "-m", "crispline", *map(str, arguments), "--threads", "1"],
            env=ENVIRONMENT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    finally:
        signal.signal(signal.SIGINT, before)
    try:
        for line in child.stderr:
            if "net" in line:
                break
        child.send_signal(signal.SIGINT)
        stdout, stderr = child.communicate(timeout=60)
    finally:
        child.kill()
    assert child.returncode == 130
    assert stdout == ""
    assert stderr.splitlines()[-1] == "Interrupted; files that were not finished are not written"
    assert "Traceback" not in stderr
    assert sorted(one.name for one in tmp_path.iterdir()) == ["box.npy", "old.step"]
    assert (tmp_path / "old.step").read_text() == "as it was"


def test_every_command_has_the_options_of_messages():
    for command in cli.main.commands.values():
        names = {name for one in command.params for name in one.opts}
        assert {"--quiet", "--verbose", "--log-json"} <= names
        assert isinstance(command, click.Command)
