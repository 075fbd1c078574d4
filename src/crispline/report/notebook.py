"""A reconstruction as a notebook shows it: what is known, without a picture."""

from __future__ import annotations

from html import escape

from crispline.report.content import result_facts, result_verdict
from crispline.report.sections import face_table, facts
from crispline.result import Reconstruction

_STYLE = """
.crispline { font-variant-numeric: tabular-nums; }
.crispline dl { display: flex; flex-wrap: wrap; gap: 4px 24px; margin: 6px 0 10px; }
.crispline dt { font-size: 85%; opacity: .7; }
.crispline dd { margin: 0; }
.crispline td i { display: inline-block; width: 9px; height: 9px; margin-right: 6px; }
.crispline th button { all: unset; }
"""


def notebook_html(result: Reconstruction) -> str:
    """Verdict, numbers and faces of a reconstruction as a fragment of HTML."""
    warnings = "".join(f"<li>{escape(warning)}</li>" for warning in result.warnings)
    return (
        f'<div class="crispline"><style>{_STYLE}</style>'
        f"<strong>{escape(result_verdict(result))}</strong>"
        f"<dl>{facts(result_facts(result).items())}</dl>"
        f"{face_table(result.faces)}"
        f"{f'<ul>{warnings}</ul>' if warnings else ''}</div>"
    )
