"""The page as text."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from crispline.errors import InputError
from crispline.findings import FaceReport
from crispline.options import Options
from crispline.report import threejs
from crispline.report.content import result_facts
from crispline.report.html import write_comparison_report, write_report

TAG = re.compile(r"<(?!script|style)[a-z][^>]*>")


def without_scripts(text):
    return re.sub(r"<(script|style).*?</\1>", "", text, flags=re.S)


def data_of(text):
    stored = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    return json.loads(stored.group(1))


def test_the_page_asks_for_nothing_outside_itself(report):
    text = report.read_text()
    markup = without_scripts(text)
    assert not re.search(r"\b(src|href|action)\s*=", markup)
    assert "url(" not in re.search(r"<style>.*?</style>", text, re.S).group(0)
    assert "default-src 'none'" in markup
    assert "Three.js Authors" in text
    assert "SPDX-License-Identifier: MIT" in text


def test_the_same_input_gives_the_same_bytes(report, cube, points, tmp_path):
    again = tmp_path / "again.html"
    write_report(again, cube, points, title="cube & co", unit="mm", options=Options())
    assert again.read_bytes() == report.read_bytes()


def test_says_everything(report):
    text = without_scripts(report.read_text())
    assert "<h1>cube &amp; co</h1>" in text
    assert "Valid closed solid" in text
    assert "<dt>points</dt><dd>2400</dd>" in text
    assert "<dt>volume</dt><dd>8000</dd>" in text
    assert text.count("<tr data-face=") == 6
    assert "12 points were left out &lt;here&gt;" in text
    assert 'data-place="10.0,10.0,10.0"' in text
    assert "2.5 s" in text
    assert "region.min_patches" in text
    assert "Deviation in mm" in text
    assert "rms 0.15, mean \N{MINUS SIGN}0.1, p95 0.15; 0 of 2400 points lie beyond it" in text


def test_a_run_without_a_solid_is_shown_as_far_as_it_came(unbuilt, points, tmp_path):
    path = tmp_path / "failed.html"
    write_report(path, unbuilt, points, failure="the net is open near (1, 2, 3)")
    text = path.read_text()
    assert 'class="verdict bad">the net is open' in text
    arrays = data_of(text)["arrays"]
    assert arrays["triangles"]["base64"] == ""
    assert arrays["quads"]["base64"]
    assert "histogram" not in without_scripts(text)


def test_text_of_others_cannot_end_the_data(cube, points, tmp_path):
    path = tmp_path / "page.html"
    write_report(path, cube, points, title="</script><b>", unit="</script><u>")
    text = path.read_text()
    assert "<b>" not in text
    assert "</script><u>" not in text
    assert "<u>" not in without_scripts(text)
    assert data_of(text)["unit"] == "</script><u>"


def test_colours_span_three_sigma_of_the_noise(report, cube, points, tmp_path):
    assert data_of(report.read_text())["limit"] == pytest.approx(0.3)
    path = tmp_path / "noisier.html"
    write_report(path, replace(cube, noise=0.47), points)
    assert data_of(path.read_text())["limit"] == pytest.approx(1.5)


def test_any_shape_can_be_compared(cube, points, tmp_path):
    path = tmp_path / "compared.html"
    shape, found = cube.solid.shape, cube.deviations(points)
    rows = [FaceReport("plane", {}, 400.0, 400, 0.15, 0.15, 0.15, -0.15, math.nan)] * 6
    write_comparison_report(
        path, shape, points, found, rows,
        spacing=1.0, verdict="within 0.2", facts={"share": "100 %"},
    )  # fmt: skip
    text = path.read_text()
    data = data_of(text)
    assert data["limit"] == pytest.approx(0.15)  # no noise given: where the deviations lie
    assert data["arrays"]["sharp_edges"]["base64"]
    assert "quads" not in data["arrays"]
    assert "<dt>share</dt><dd>100 %</dd>" in text


def test_another_suffix_is_refused(cube, points, tmp_path):
    with pytest.raises(InputError, match=r"ends in \.html"):
        write_report(tmp_path / "report.pdf", cube, points)


def test_a_trimesh_without_its_viewer_is_told(monkeypatch):
    import trimesh.viewer

    monkeypatch.setattr(trimesh.viewer, "scene_to_html", lambda scene: "<html></html>")
    threejs.three_js.cache_clear()
    with pytest.raises(InputError, match="pip install 'trimesh"):
        threejs.three_js()
    monkeypatch.undo()
    assert "REVISION" in threejs.three_js()


def test_notebooks_show_the_verdict_and_the_faces(cube, unbuilt):
    text = cube._repr_html_()
    assert "Valid closed solid" in text
    assert text.count("<tr data-face=") == 6
    assert "&lt;here&gt;" in text
    assert "No valid model" in unbuilt._repr_html_()


def test_unknown_areas_are_dashes(unbuilt):
    assert np.isnan(unbuilt.faces[0].area)
    assert '<td class="" data-value="">\N{EN DASH}</td>' in unbuilt._repr_html_()


def test_the_faces_of_a_model_of_patches_are_counted_in_its_shape(cube):
    patches = replace(cube.solid, face_order=(-1,) * 9, representation="patches")
    assert result_facts(replace(cube, solid=patches))["faces"] == "9"
