// The table of faces: sorting, and the row that is selected. It works without the view.
class FaceTable {
  constructor(selected) {
    this.table = document.getElementById("faces");
    this.selected = selected;
    if (!this.table) return;
    this.body = this.table.tBodies[0];
    [...this.table.tHead.rows[0].cells].forEach((head, column) => {
      head.setAttribute("aria-sort", column ? "none" : "ascending");
      head.firstElementChild.addEventListener("click", () => this.sort(head, column));
    });
    this.body.addEventListener("click", (e) => this.choose(e.target.closest("tr")));
    this.body.addEventListener("keydown", (e) => this.key(e));
  }

  sort(head, column) {
    const isUp = head.getAttribute("aria-sort") !== "ascending";
    for (const each of head.parentElement.cells) each.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", isUp ? "ascending" : "descending");
    const value = (row) => row.cells[column].dataset.value;
    const isText = [...this.body.rows].some((row) => Number.isNaN(Number(value(row))));
    const compare = (a, b) => {
      const [x, y] = [value(a), value(b)];
      if (x === "" || y === "") return (x === "") - (y === "");  // what is not known comes last
      return (isUp ? 1 : -1) * (isText ? x.localeCompare(y) : x - y);
    };
    this.body.append(...[...this.body.rows].sort(compare));
  }

  key(e) {
    const row = e.target.closest("tr");
    const next = { ArrowDown: row.nextElementSibling, ArrowUp: row.previousElementSibling }[e.key];
    if (next) next.focus();
    else if (e.key === "Enter" || e.key === " ") this.choose(row);
    else if (e.key === "Escape") this.selected(null);
    else return;
    e.preventDefault();
  }

  choose(row) {
    if (row) this.selected(row.getAttribute("aria-selected") === "true" ? null : Number(row.dataset.face));
  }

  select(face) {
    if (!this.table) return;
    for (const row of this.body.rows) {
      const isIt = Number(row.dataset.face) === face;
      row.setAttribute("aria-selected", isIt);
      if (isIt) row.scrollIntoView({ block: "nearest" });
    }
  }
}
