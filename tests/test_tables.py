# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tables of the README, and of the page of all, are what the demos wrote."""

import importlib.util
import re
from pathlib import Path

DEMOS = Path(__file__).resolve().parent.parent / "demos"
spec = importlib.util.spec_from_file_location("tables", DEMOS / "tables.py")
tables = importlib.util.module_from_spec(spec)
spec.loader.exec_module(tables)


def test_pages_show_what_the_demos_wrote():
    shown = []
    for page in (tables.README, tables.ALL):
        text = page.read_text()
        assert tables.filled(text) == text
        shown.append({match[1] for match in tables.BLOCK.finditer(text)})
    assert shown[0] == {"rocking_block", "error_against_run_time", "stability_map"}
    assert shown[1] == {file.stem for file in tables.TABLES.glob("*.md")}


def test_every_table_tells_whence_it_comes():
    for file in tables.TABLES.glob("*.md"):
        last = file.read_text().strip().splitlines()[-1]
        assert last.startswith(f"`./run demos/{file.stem}.py`: ")
        assert re.search(r"dolfinx \d.*system .*date \d{4}-\d\d-\d\d", last)


def test_full_runs_are_taken_over_and_quick_ones_are_not(tmp_path, monkeypatch):
    monkeypatch.setattr(tables, "TABLES", tmp_path / "tables")
    monkeypatch.setattr(tables, "RESULTS", tmp_path / "results")
    tables.TABLES.mkdir()
    for name, command in (("full", "./run demos/full.py"), ("quick", "./run demos/x.py --quick")):
        (tables.RESULTS / name).mkdir(parents=True)
        (tables.RESULTS / name / "table.md").write_text(f"| 1 |\n\n`{command}`: here.\n")
    assert tables.collect() == ["full"]
    blocks = 2 * "a\n<!-- full -->\n{0}<!-- end -->\nb\n"  # a block ends where it ends
    new = "| 1 |\n\n`./run demos/full.py`: here.\n"
    assert tables.filled(blocks.format("old\n")) == blocks.format(new)
