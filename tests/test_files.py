import pytest

from crispline.errors import InputError
from crispline.files import atomic_path, check_output, write_text


def test_a_file_appears_whole(tmp_path):
    target = tmp_path / "out.txt"
    with atomic_path(target) as draft:
        assert draft.name == target.name
        draft.write_text("half")
        assert not target.exists()
        draft.write_text("whole")
    assert target.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, ValueError])
def test_an_interrupted_write_leaves_the_old_file(tmp_path, interruption):
    target = tmp_path / "out.txt"
    target.write_text("old")

    def write_half() -> None:
        with atomic_path(target) as draft:
            draft.write_text("half")
            raise interruption

    with pytest.raises(interruption):
        write_half()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_failing_disk_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="No space left"), atomic_path(tmp_path / "out.txt"):
        raise OSError(28, "No space left on device")
    assert list(tmp_path.iterdir()) == []


def test_a_link_is_followed(tmp_path):
    target, link = tmp_path / "target.txt", tmp_path / "link.txt"
    target.write_text("old")
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a.stl", "expected a name that ends in .step or .stp, got '.stl'"),
        ("step", "got 'step'"),
        ("none/a.step", "does not exist"),
        ("folder.step", "it is a folder"),
    ],
)
def test_outputs_refused_beforehand(tmp_path, name, message):
    (tmp_path / "folder.step").mkdir()
    with pytest.raises(InputError, match=message):
        check_output(tmp_path / name, (".step", ".stp"))


def test_suffixes_have_no_case(tmp_path):
    check_output(tmp_path / "A.STEP", (".step",))
