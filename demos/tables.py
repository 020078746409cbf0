# SPDX-License-Identifier: LGPL-3.0-or-later
"""Put the tables that the demos wrote where they are shown: no figure there is typed by hand.

`./run demos/tables.py` takes `results/<demo>/table.md` of every full run (not of `--quick`) that
stands there into `demos/tables/`, and what stands in `demos/tables/` between the markers
`<!-- <demo> -->` and `<!-- end -->` of the README, which has some, and of the page of all.
"""

import re
from pathlib import Path

HERE = Path(__file__).resolve().parent
README, TABLES, RESULTS = HERE.parent / "README.md", HERE / "tables", Path("results")
ALL = HERE / "site" / "reference" / "measured.md"
BLOCK = re.compile(r"(?<=<!-- )(?!end )(\w+)( -->\n).*?(?=<!-- end -->)", re.DOTALL)


def collect() -> list[str]:
    """Take over the tables of the last full runs; the names of their demos."""
    taken = []
    for file in sorted(RESULTS.glob("*/table.md")):
        text = file.read_text()
        if " --quick`" not in text:
            (TABLES / f"{file.parent.name}.md").write_text(text)
            taken.append(file.parent.name)
    return taken


def filled(page: str) -> str:
    """The page with the tables as they stand.

    Raises:
        FileNotFoundError: a marker names no table.
    """
    return BLOCK.sub(lambda m: m[1] + m[2] + (TABLES / f"{m[1]}.md").read_text(), page)


def main() -> None:
    """Everything."""
    TABLES.mkdir(exist_ok=True)
    taken = collect()
    for page in (README, ALL):
        page.write_text(filled(page.read_text()))
    print(f"taken over: {', '.join(taken) or 'nothing'}; {README.name} and {ALL.name} written")


if __name__ == "__main__":
    main()
