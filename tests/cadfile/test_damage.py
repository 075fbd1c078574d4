"""STEP and IGES files that are cut off or altered are refused, whatever is wrong."""

import numpy as np
import pytest

from crispline.cadfile.damage import iges_damage, step_damage
from crispline.cadfile.step import open_step
from crispline.cadfile.surface_files import read_faces, write_faces
from crispline.errors import InputError
from crispline.spline.tensor import spline_over_grid


@pytest.fixture(scope="module")
def contents(tmp_path_factory):
    """A sound file of either kind."""
    i, j = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    spline = spline_over_grid(np.stack([i, j, np.sin(i + j)], axis=-1))
    folder = tmp_path_factory.mktemp("sound")
    for suffix in (".step", ".igs"):
        write_faces(folder / f"a{suffix}", [spline])
    return {suffix: (folder / f"a{suffix}").read_bytes() for suffix in (".step", ".igs")}


def test_sound_files_have_no_damage(contents):
    assert step_damage(open_step(contents[".step"])) is None
    assert iges_damage(contents[".igs"]) is None
    assert iges_damage(contents[".igs"].replace(b"\n", b"\r\n") + b"\r\n") is None


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_a_file_cut_off_anywhere_is_refused(contents, suffix, tmp_path, capfd):
    content = contents[suffix]
    path = tmp_path / f"a{suffix}"
    for share in np.linspace(0.001, 0.998, 40):
        path.write_bytes(content[: int(share * len(content))])
        with pytest.raises(InputError, match=r"expected .* file with a shape, found content"):
            read_faces(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (b",(4,1,1,1,4),(0.,", b",(4,1,1,1,4),$0.,", "Incorrect syntax"),
        (b"EDGE_CURVE('',#", b"EDGE_CURVE('',#9", "Unresolved Reference"),
        (b",.F.,.F.,(4,", b",.F.,(4,", "BSplineCurveWithKnots 26: Count of Parameters is not 9"),
    ],
)
def test_records_that_do_not_fit_are_named(contents, old, new, sentence):
    assert old in contents[".step"]
    damage = step_damage(open_step(contents[".step"].replace(old, new, 1)))
    assert sentence in damage


def test_odd_records_about_products_and_unknown_ones_do_no_harm(contents):
    content = contents[".step"]
    odd = content.replace(b"'part definition',#2,'design')", b"'part definition',#2)")
    odd = odd.replace(b"ENDSEC;\nEND-ISO", b"#9000 = NEW_KIND('x',#1);\nENDSEC;\nEND-ISO")
    assert odd.count(b"NEW_KIND") == 1
    assert len(odd) != len(content)
    assert step_damage(open_step(odd)) is None


def lines(content):
    return content.decode("ascii").splitlines()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: t[:-1], "the last line, with the counts of the others, is missing"),
        (lambda t: t[:20] + t[21:], "line 21 does not end in its section and number"),
        (lambda t: [*t[:20], t[20][5:], *t[21:]], "line 21 does not end in its section"),
        (lambda t: [*t[:20], t[20][:64] + "00000702" + t[20][72:], *t[21:]], "line 21 belongs to"),
        (lambda t: [*t[:20], t[20][:64] + "00000903" + t[20][72:], *t[21:]], "line 21 belongs to"),
        (lambda t: [*t[:-2], t[-1]], "lines of section P announced"),
        (lambda t: [], "the last line"),
        (lambda t: ["solid"], "line 1 does not end in its section and number"),
    ],
)
def test_lines_that_do_not_fit_are_named(contents, change, sentence):
    assert sentence in iges_damage("\n".join(change(lines(contents[".igs"]))).encode("ascii"))
