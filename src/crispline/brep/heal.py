"""OCCT's shape healing, in a process of its own.

Healing has been seen to run for ever on a bad face, and a thread in C++ cannot be
stopped. So it runs in a child process that is ended after a time limit. The child
is started by its module name, which needs no main-module guard in user scripts.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.ShapeFix import ShapeFix_Edge, ShapeFix_Shape

from crispline import occt

_PRECISION = 1e-6


def heal(
    shape: Any, max_tolerance: float, time_limit: float, drop_pcurves: bool = False
) -> Any | None:
    """Let OCCT repair a shape.

    Parameters
    ----------
    shape : any ``TopoDS_Shape``; it is not changed.
    max_tolerance : largest tolerance that healing may give an edge or vertex (length unit).
    time_limit : seconds after which healing is given up.
    drop_pcurves : whether the parameter curves of faulty faces are made anew by OCCT.

    Returns
    -------
    The healed shape, which may be as faulty as before, or None if the child process
    failed or took too long.
    """
    if time_limit <= 0.0:
        return None
    # The child must find the same package, also where the parent changed its path.
    package_root = str(Path(__file__).parents[2])
    search_path = os.pathsep.join(filter(None, [package_root, os.environ.get("PYTHONPATH", "")]))
    with tempfile.TemporaryDirectory(prefix="crispline-") as folder:
        source, target = Path(folder, "faulty.brep"), Path(folder, "healed.brep")
        source.write_bytes(occt.to_text(shape))
        command = [sys.executable, "-m", __name__, str(source), str(target)]
        command += [repr(float(max_tolerance)), str(int(drop_pcurves))]
        try:
            subprocess.run(
                command,
                env={**os.environ, "PYTHONPATH": search_path},
                timeout=time_limit,
                check=True,
                stdin=subprocess.DEVNULL,
                capture_output=True,
            )
            return occt.from_text(target.read_bytes())
        except (subprocess.SubprocessError, OSError):
            return None


def heal_here(shape: Any, max_tolerance: float, drop_pcurves: bool) -> Any:
    """What the child process does; see :func:`heal`."""
    if drop_pcurves:
        _drop_faulty_pcurves(shape)
    fixer = ShapeFix_Shape(shape)
    fixer.SetPrecision(_PRECISION)
    fixer.SetMaxTolerance(max_tolerance)
    fixer.Perform()
    healed = fixer.Shape()
    for solid in occt.subshapes(healed, occt.SOLID):
        BRepLib.OrientClosedSolid_s(solid)
    return healed


def _drop_faulty_pcurves(shape: Any) -> None:
    analyser, editor = BRepCheck_Analyzer(shape), ShapeFix_Edge()
    for face in occt.subshapes(shape, occt.FACE):
        if not analyser.IsValid(face):
            for edge in occt.subshapes(face, occt.EDGE):
                editor.FixRemovePCurve(edge, face)


def _main(source: str, target: str, max_tolerance: str, drop_pcurves: str) -> None:
    shape = occt.from_text(Path(source).read_bytes())
    healed = heal_here(shape, float(max_tolerance), drop_pcurves == "1")
    Path(target).write_bytes(occt.to_text(healed))


if __name__ == "__main__":
    _main(*sys.argv[1:])
