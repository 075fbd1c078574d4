"""Settings as TOML: one source, there and back, and what is refused."""

import dataclasses
import tomllib

import pytest

from crispline.configuration import Configuration, changed, read, read_text, settings, to_toml
from crispline.errors import InputError
from crispline.options import FitOptions, NetOptions, Options, SharpenOptions


def test_what_is_written_reads_back_as_the_defaults(tmp_path):
    path = tmp_path / "all.toml"
    path.write_text(to_toml(), encoding="utf-8")
    assert read(path) == Configuration(Options(), SharpenOptions())


def test_other_values_read_back_too():
    given = Configuration(
        Options(seed=7, model="patches", net=NetOptions(edge_lengths=(1.0,), fill_holes=15.5)),
        SharpenOptions(rule="paper", eps=0.25),
    )
    assert read_text(to_toml(given)) == given
    names = {"seed", "model", "net.edge_lengths", "net.fill_holes", "sharpen.rule", "sharpen.eps"}
    assert {one.name for one in changed(given)} == names
    assert changed(Configuration()) == []


def test_every_field_has_a_setting_with_a_meaning():
    def n_leaves(options):
        values = [getattr(options, one.name) for one in dataclasses.fields(options)]
        return sum(n_leaves(v) if dataclasses.is_dataclass(v) else 1 for v in values)

    found = settings()
    assert len(found) == n_leaves(Options()) + n_leaves(SharpenOptions())
    assert len({one.name for one in found}) == len(found)
    assert [one.name for one in found if len(one.meaning) < 10] == []


def test_every_setting_stands_in_the_file_under_its_table():
    content = tomllib.loads(to_toml())
    for one in settings():
        place = content[one.table] if one.table else content
        assert (one.key in place) == (one.value is not None)


def test_the_meaning_is_the_text_under_the_field():
    text = to_toml()
    assert "# Widest gap in the scan that is closed on an open surface, in spacings.\n" in text
    assert "cut_deg = 10.0  # degrees\n" in text
    assert "``" not in text


def test_what_is_left_out_keeps_its_default():
    given = read_text("threads = 2\n[fit]\nregularize = false\n")
    assert given.options == Options(threads=2, fit=FitOptions(regularize=False))
    assert read_text("") == Configuration()


def test_whole_numbers_are_numbers():
    assert read_text("net.fill_holes = 15").options.net.fill_holes == 15.0
    assert isinstance(read_text("net.fill_holes = 15").options.net.fill_holes, float)
    assert read_text("sharpen.eps = 1").sharpen.eps == 1.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[net]\nfill_hole = 3", "unknown key 'net.fill_hole'; did you mean 'net.fill_holes'?"),
        ("fill_holes = 3", "unknown key 'fill_holes'; did you mean 'net.fill_holes'?"),
        ("[nett]\nfill_holes = 3", "did you mean 'net.fill_holes'?"),
        ("[fit]\nrule = 'paper'", "did you mean 'sharpen.rule'?"),
        ("zzzz = 3", "unknown key 'zzzz'; `crispline --dump-options` lists them"),
        ("[nothing]", "unknown key 'nothing'"),
        ("net = 3", "'net': expected a table `[net]`, found 3"),
        ("seed = 'one'", "'seed': expected a whole number of 0 or more, found \"one\""),
        ("seed = 1.5", "'seed': expected a whole number of 0 or more, found 1.5"),
        ("seed = true", "'seed': expected a whole number of 0 or more, found true"),
        ("seed = -1", "found -1"),
        ("seed = {a = 1}", "found a table"),
        ("net.fill_holes = inf", "'net.fill_holes': expected a number of 0 or more, found inf"),
        ("net.fill_holes = nan", "found nan"),
        (f"net.fill_holes = {10**400}", "expected a number of 0 or more"),
        ("net.fill_holes = true", "expected a number of 0 or more, found true"),
        ("net.surface = 'ajar'", 'expected "auto" or "open" or "closed", found "ajar"'),
        ("net.surface = [1]", "found [1]"),
        ("net.edge_lengths = []", "expected a list of numbers of 0 or more, found []"),
        ("net.edge_lengths = 1.0", "expected a list of numbers of 0 or more, found 1.0"),
        ("net.edge_lengths = 'ab'", 'found "ab"'),
        (
            "net.projection_steps = [1]",
            "expected a list of 2 whole numbers of 0 or more, found [1]",
        ),
        ("net.projection_steps = [1, 2.5]", "found [1, 2.5]"),
        ("fit.regularize = 1", "expected true or false, found 1"),
        ("fit.regularize = 2026-11-22", "expected true or false, found 2026-11-22"),
        ("sharpen.eps = 'x'", "'sharpen.eps': expected a number of 0 or more, found \"x\""),
        ("net fill_holes", "expected settings in TOML"),
    ],
)
def test_what_is_refused(text, message):
    with pytest.raises(InputError) as caught:
        read_text(text, "'a.toml'")
    assert str(caught.value).startswith("'a.toml': ")
    assert message in str(caught.value)


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00"])
def test_a_file_that_cannot_be_read(tmp_path, content):
    path = tmp_path / "a.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match="a file of settings in TOML"):
        read(path)
