import io
import json

import numpy as np
from click.testing import CliRunner
from rich.console import Console

from crispline.cli import main
from crispline.cloud.inspection import inspect
from crispline.cloud.pointcloud import PointCloud
from crispline.report.inspect import inspection_summary, render_inspection
from crispline.shapes import SHAPES, sample

SCAN = sample(SHAPES["bracket"](), 4000, noise=0.005, seed=1).points


def test_text_and_json_say_the_same():
    found = inspect(PointCloud.from_arrays(SCAN))
    content = json.loads(json.dumps(inspection_summary(found), allow_nan=False))
    console = Console(file=io.StringIO(), width=200)
    console.print(render_inspection(found))
    text = console.file.getvalue()
    for part in (
        f"{len(SCAN)}, in no order, with no normals",
        f"{content['spacing']:.4g}",
        f"faces narrower than {content['faces_lost_below']:.3g} (3 spacings) are lost",
        f"walls thinner than {content['walls_merge_below']:.3g} (2) merge",
        "mm? ",
        "takes about",
    ):
        assert part in text
    assert content["n_points"] == len(SCAN)


def test_the_command(tmp_path):
    np.save(tmp_path / "scan.npy", SCAN)
    out = tmp_path / "scan.json"
    run = CliRunner().invoke(main, ["inspect", str(tmp_path / "scan.npy"), "--json", str(out)])
    assert run.exit_code == 0, run.output
    assert json.loads(out.read_text())["n_points"] == len(SCAN)
    assert "noise" in run.output
    missing = CliRunner().invoke(main, ["inspect", str(tmp_path / "no.npy")])
    assert (missing.exit_code, "no such file" in missing.output) == (2, True)
