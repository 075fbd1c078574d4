"""What a report says of a reconstruction or a comparison: pages without their text."""

from __future__ import annotations

from collections.abc import Mapping

from crispline.gauge.distance import Deviations
from crispline.options import Options
from crispline.report.page import Page, option_rows
from crispline.report.scene import scene_of
from crispline.report.sections import number
from crispline.result import Reconstruction
from crispline.surface.base import Array


def result_page(
    result: Reconstruction,
    points: Array,
    *,
    title: str = "Reconstruction",
    unit: str = "",
    options: Options | None = None,
    failure: str | None = None,
) -> Page:
    """The page of a run; see :func:`crispline.report.html.write_report`."""
    found: Deviations | None = None
    if result.solid is not None and result.solid.face_order:
        found = result.deviations(points)
    return Page(
        title=title,
        verdict=failure or result_verdict(result),
        is_good=failure is None and result.valid,
        facts=tuple({**result_facts(result), "points": f"{len(points)}"}.items()),
        faces=result.faces,
        scene=scene_of(result, points, found),
        spacing=result.spacing,
        noise=result.noise,
        unit=unit,
        warnings=result.warnings,
        timings=result.timings,
        options={} if options is None else option_rows(options),
    )


def result_facts(result: Reconstruction) -> Mapping[str, str]:
    """Counts and lengths, ready to be shown."""
    known = {
        "faces": f"{len(result.model.faces if result.solid is None else result.solid.face_order)}",
        "sharp edges": f"{sum(edge.is_sharp for edge in result.model.edges)}",
        "corners": f"{len(result.corners)}",
        "spacing": number(result.spacing),
        "noise": number(result.noise, 3),
        "noise / spacing": number(result.noise / result.spacing, 2),
    }
    if result.solid is not None and result.closed:
        known["volume"] = number(result.solid.check.volume)
    return known


def result_verdict(result: Reconstruction) -> str:
    """What came out, in a few words."""
    if not result.valid:
        return "No valid model"
    assert result.solid is not None
    kind = "Valid closed solid" if result.closed else "Valid open shell"
    of = {"mixed": ", some regions as bicubic patches", "patches": " of bicubic patches"}
    measured = "" if result.certificate is None else f": {result.verdict}"
    return kind + of.get(result.solid.representation, "") + measured
