"""Put the tables of a run of ``crispline paper`` into the documentation.

python docs/paper_table.py T.json
"""

from __future__ import annotations

import json
import sys
from datetime import date
from pathlib import Path

from crispline.paper.rows import Row
from crispline.paper.table import to_markdown

HERE = Path(__file__).parent
MARKS = "<!-- table -->\n", "<!-- end of table -->\n"


def main() -> None:
    """Write `paper-table.md`, and its first part between the marks of `paper.md`."""
    rows = [Row(**row) for row in json.loads(Path(sys.argv[1]).read_text())]
    tables = to_markdown(rows)
    (HERE / "paper-table.md").write_text(tables)
    first = tables.split("\n## Every sampling")[0].split("\n", 2)[2]
    page = (HERE / "paper.md").read_text()
    before, rest = page.split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    heading = "## The worst sampling of every method"
    first = first.replace(heading, f"Run on {date.today()}. {heading[3:]}:")
    (HERE / "paper.md").write_text(f"{before}{MARKS[0]}\n{first}\n{MARKS[1]}{after}")


if __name__ == "__main__":
    main()
