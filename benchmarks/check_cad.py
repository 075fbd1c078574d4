"""Whether other programs read the solids: FreeCAD and gmsh STEP and IGES, openNURBS 3DM.

    python benchmarks/check_cad.py            # makes out/cad/ first: two parts, three formats
    python benchmarks/check_cad.py FILE ...   # STEP, IGES and 3DM files that are there

The programs are called from outside, `freecadcmd` and `gmsh`; one that is not installed
is skipped. For each file the table gives what the program found beside what was written:
one valid solid, the number of faces and the volume. gmsh fills the solid with
tetrahedra, which no gap in it would survive. Exit code 1 if anything differs.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import crispline
from crispline import occt
from crispline.cadfile.shape_files import read_millimetres
from crispline.occt.measure import diagonal, volume
from crispline.shapes import SHAPES, sample

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "out" / "cad"
FORMATS = (".step", ".igs", ".3dm")
MESH_SHARE = 0.02
"""Volume that flat tetrahedra may miss at round faces."""
TIME_LIMIT = 600.0

FREECAD = """
import json, sys, Part
shape = Part.read({path!r})
found = dict(valid=shape.isValid(), solids=len(shape.Solids), faces=len(shape.Faces),
             volume=shape.Volume)
open({answer!r}, "w").write(json.dumps(found))
"""


@dataclass(frozen=True)
class Found:
    """What a program says of a file; lengths in millimetres, -1 for what it does not tell."""

    is_valid: bool
    n_solids: int
    n_faces: int
    volume: float
    slack: float = 1e-4


def main() -> int:
    """Check the files that are named, or those made here; print the table."""
    files = [Path(name) for name in sys.argv[1:]] or make()
    n_bad = 0
    print(
        f"{'file':24} {'program':9} {'valid':>5} {'solids':>6} {'faces':>9} {'volume':>12}  result"
    )
    for file in files:
        for program, (look, suffixes) in PROGRAMS.items():
            if file.suffix.lower() not in suffixes:
                continue
            found = look(file)
            if found is None:
                print(f"{file.name:24} {program:9} not installed: skipped")
                continue
            n_bad += not report(file, program, found)
    return 1 if n_bad else 0


def make() -> list[Path]:
    """Reconstruct the box with the cylinder and the bundled scan, and write them."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    box = sample(SHAPES["box-cylinder"](), 20000, noise=0.005, seed=1)
    clouds = {
        "box-cylinder": crispline.PointCloud(box.points),
        "bracket": crispline.read_points(ROOT / "examples" / "bracket.ply"),
    }
    files = []
    for name, cloud in clouds.items():
        part = crispline.reconstruct(cloud)
        for suffix in FORMATS:
            file = FOLDER / f"{name}{suffix}"
            part.write(file)
            files.append(file)
    return files


def report(file: Path, program: str, found: Found) -> bool:
    """Print a row; whether the program agrees with what crispline reads in the file."""
    # OCCT does not read 3DM: the STEP file beside it is the same model.
    twin = file.with_suffix(".step") if file.suffix.lower() == ".3dm" else file
    shape, _ = read_millimetres(twin)
    n_faces, expected = len(occt.subshapes(shape, occt.FACE)), volume(shape)
    has_volume = found.volume >= 0.0
    error = (found.volume - expected) / expected if has_volume else 0.0
    is_good = (
        found.is_valid
        and found.n_solids in (1, -1)
        and found.n_faces in (n_faces, -1)
        and abs(error) <= found.slack
    )
    faces = f"{found.n_faces}/{n_faces}" if found.n_faces >= 0 else "-"
    solids = str(found.n_solids) if found.n_solids >= 0 else "-"
    share = f"{100.0 * error:+.4f} %" if has_volume else "-"
    print(
        f"{file.name:24} {program:9} {'yes' if found.is_valid else 'no':>5} {solids:>6} "
        f"{faces:>9} {share:>12}  {'agrees' if is_good else 'DIFFERS'}"
    )
    return is_good


def freecad(file: Path) -> Found | None:
    """Read with FreeCAD's Part module."""
    program = shutil.which("freecadcmd") or shutil.which("FreeCADCmd")
    if program is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        script, answer = Path(folder, "look.py"), Path(folder, "answer.json")
        script.write_text(FREECAD.format(path=str(file.resolve()), answer=str(answer)))
        subprocess.run(
            [program, str(script)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=TIME_LIMIT,
            check=False,
        )
        if not answer.exists():
            return Found(False, 0, 0, 0.0)
        found = json.loads(answer.read_text())
    return Found(found["valid"], found["solids"], found["faces"], found["volume"])


def gmsh(file: Path) -> Found | None:
    """Fill the solid with tetrahedra and add up their volumes."""
    program = shutil.which("gmsh")
    if program is None:
        return None
    shape, _ = read_millimetres(file)
    size = diagonal(shape) / 30.0
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder, "mesh.msh")
        done = subprocess.run(
            [
                *(program, str(file.resolve()), "-3", "-format", "msh22", "-o", str(mesh)),
                *("-clmax", str(size), "-clcurv", "20", "-v", "1"),
            ],
            capture_output=True,
            timeout=TIME_LIMIT,
            check=False,
        )
        if done.returncode != 0 or not mesh.exists():
            return Found(False, 0, -1, 0.0)
        filled, n_volumes = tetrahedra_volume(mesh.read_text())
    return Found(filled > 0.0, n_volumes, -1, filled, MESH_SHARE)


def tetrahedra_volume(text: str) -> tuple[float, int]:
    """Volume of the tetrahedra in a mesh (MSH 2.2, ASCII), and of how many bodies they are."""
    lines = text.splitlines()
    start = lines.index("$Nodes") + 2
    nodes = np.loadtxt(lines[start : lines.index("$EndNodes")], ndmin=2)
    place = {int(number): row for row, number in enumerate(nodes[:, 0])}
    start = lines.index("$Elements") + 2
    rows = [line.split() for line in lines[start : lines.index("$EndElements")]]
    solid = [row for row in rows if row[1] == "4"]
    if not solid:
        return 0.0, 0
    corners = nodes[[[place[int(node)] for node in row[-4:]] for row in solid], 1:]
    sides = corners[:, 1:] - corners[:, :1]
    return float(np.abs(np.linalg.det(sides)).sum() / 6.0), len({row[4] for row in solid})


def opennurbs(file: Path) -> Found | None:
    """Read with rhino3dm, the library of Rhino's own files."""
    try:
        rhino3dm: Any = import_module("rhino3dm")
    except ImportError:
        return None
    solids = [one.Geometry for one in rhino3dm.File3dm.Read(str(file)).Objects]
    is_valid = all(one.IsValid and one.IsSolid for one in solids)
    return Found(is_valid, len(solids), sum(len(one.Faces) for one in solids), -1.0)


_EXCHANGE = (".step", ".stp", ".iges", ".igs")
PROGRAMS: Mapping[str, tuple[Callable[[Path], Found | None], tuple[str, ...]]] = {
    "FreeCAD": (freecad, _EXCHANGE),
    "gmsh": (gmsh, _EXCHANGE),
    "openNURBS": (opennurbs, (".3dm",)),
}

if __name__ == "__main__":
    raise SystemExit(main())
