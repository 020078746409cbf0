# SPDX-License-Identifier: LGPL-3.0-or-later
"""The site: it is built from clean, every page is opened in headless Chromium, wide and narrow;
every reason for which a run can stop is on its page; what plays in the browser computes rightly."""

import ast
import html.parser
import importlib
import inspect
import json
import os
import re
import runpy
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
from test_lessons import LESSONS, learn

import fenicsx_contact
from fenicsx_contact import gradients, rods, study
from fenicsx_contact.contact.wall import Obstacle
from fenicsx_contact.output import stop, stops
from fenicsx_contact.rods.drive import AxialLaw
from fenicsx_contact.solids.damping import Damping
from fenicsx_contact.theory.formulations import Formulation
from fenicsx_contact.theory.friction import FrictionBound
from fenicsx_contact.theory.scheme import Scheme
from fenicsx_contact.theory.weak_form import ContactFields

TOP = Path(__file__).resolve().parent.parent
SITE = TOP / "demos" / "site"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
WIDTHS = (400, 1400)


def test_every_reason_to_stop_is_on_its_page():
    page = (SITE / "reference" / "stops.md").read_text()
    assert all(f"generated/stops_{section}.md" in page for section in stops.STOPS)
    page += "".join(map(stop.table, stops.STOPS.values()))
    found = runpy.run_path(str(SITE / "reasons.py"))["reasons"]()
    assert len(found) >= 20
    assert not [each for each in found if f"`{each[1]}`" not in page]


LISTED = [stop for section in stops.STOPS.values() for stop in section]


@pytest.mark.parametrize("stop", LISTED, ids=lambda stop: stop.name)
def test_a_reason_leads_to_its_row(stop):
    """What a run says has a name of its own, and advice; as it stands in the middle of a reason."""
    assert [other.name for other in LISTED].count(stop.name) == 1
    said = "stopped at t = 1 s: " + stop.says.replace("...", "7.5e-3") + "; steps down to 1 s fail"
    assert stops.hint(said) == f" (see: when it stops, {stop.name!r})"
    assert stop.remedy in stops.advice(said) and stops.explained("finished") == []


def test_lessons_are_on_the_page_of_what_comes_after():
    page = (SITE / "index.md").read_text()
    assert all(path.exists() for path in map((TOP / "demos").joinpath, demos(page)))


def demos(text):
    return {
        word for word in text.replace("`", " ").split() if word.endswith(".py") and "/" not in word
    }


def test_which_and_when_names_what_there_is():
    """Classes on that page are of the package, their named arguments theirs."""
    page = (SITE / "reference" / "which.md").read_text()
    calls = re.findall(r"`([A-Z][A-Za-z]+)(?:\(([^`]*)\))?`", page)
    assert len(calls) > 15
    for name, given in calls:
        known = inspect.signature(getattr(fenicsx_contact, name)).parameters
        assert set(re.findall(r"(\w+)=", given)) <= set(known), name


@pytest.mark.parametrize(
    "protocol",
    [ContactFields, FrictionBound, Formulation, Obstacle, Damping, Scheme, AxialLaw],
)
def test_what_own_parts_need_is_on_their_page(protocol):
    page = (SITE / "reference" / "extend.md").read_text()
    needed = [*vars(protocol), *vars(protocol).get("__annotations__", ())]
    named = re.findall(r"`([a-z_]+)(?:\(.*?\))?`", page)
    assert [name for name in needed if not name.startswith("_") and name not in named] == []


def included():
    """(file, options, lines) of every piece of code that a page takes from the source."""
    files = re.findall(r'"((?:fenicsx_contact|demos)/\S+\.py)"', (SITE / "generate.py").read_text())
    paths = {Path(name).name: TOP / name for name in files}
    for page in (SITE / "theory.md", SITE / "reference" / "extend.md"):
        pieces = r"```\{literalinclude\} \S*code/(\S+)\n(.*?)```"
        for name, told in re.findall(pieces, page.read_text(), re.S):
            options = dict(re.findall(r':([\w-]+): *"?(.*?)"?$', told, re.M))
            yield name, options, cut(paths[name].read_text(), options)


def cut(text, options):
    """The lines that Sphinx takes by these options."""
    lines = text.splitlines()
    if "pyobject" in options:
        node = ast.parse(text)
        for name in options["pyobject"].split("."):
            node = next(each for each in node.body if getattr(each, "name", None) == name)
        first = min([node.lineno, *(each.lineno for each in node.decorator_list)])
        lines = lines[first - 1 : node.end_lineno]
    if "start-at" in options:
        lines = lines[next(i for i, line in enumerate(lines) if options["start-at"] in line) :]
    if "end-at" in options:
        lines = lines[: 1 + next(i for i, line in enumerate(lines) if options["end-at"] in line)]
    kept = []
    for part in options.get("lines", "1-").split(","):
        start, to, end = part.partition("-")
        kept += lines[int(start) - 1 : int(end or len(lines)) if to else int(start)]
    return kept


def test_code_on_a_page_is_whole_and_runs():
    """What is shown is code, no torn docstring, and the laws shown are those that are solved."""
    pieces = list(included())
    assert len(pieces) > 20
    solved = (TOP / "demos" / "equation_7.py").read_text()
    solved += (TOP / "fenicsx_contact" / "theory" / "weak_form.py").read_text()
    for name, options, lines in pieces:
        ast.parse(textwrap.dedent("\n".join(lines)))
        if name == "laws.py":
            assert re.search(rf"\b{options['pyobject']}\(", solved), options


PAGES = sorted([*SITE.rglob("*.md"), *(TOP / "demos").glob("*.md"), TOP / "README.md"])
PAGES += sorted([*(TOP / "demos").glob("*.py"), *(TOP / "demos" / "lessons").rglob("*.py")])


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(TOP)))
def test_rows_of_a_table_have_as_many_cells(page):
    """A bar within a formula would be the border of a cell."""
    text, mark = page.read_text(), "# " if page.suffix == ".py" else ""
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    for table in re.findall(rf"(?:^{mark}\|.*\n)+", text, re.M):
        assert len({row.replace("\\|", "").count("|") for row in table.splitlines()}) == 1, table


def test_the_api_has_every_name():
    """Classes and functions that can be imported, and those alone."""
    page = (SITE / "reference" / "api.md").read_text()
    told = set(re.findall(r"auto(?:class|function):: fenicsx_contact\.(\S+)", page))
    for package, of in (
        (fenicsx_contact, ""),
        (rods, "rods."),
        (gradients, "gradients."),
        (study, "study."),
    ):
        things = {name: getattr(package, name) for name in package.__all__}
        public = {of + n for n, thing in things.items() if callable(thing)}
        private = {of + n for n, thing in things.items() if getattr(thing, "_is_protocol", False)}
        assert not public - private - told
    for path in told:
        module, _, name = f"fenicsx_contact.{path}".rpartition(".")
        assert hasattr(importlib.import_module(module), name)


def documented():
    """Docstrings that the pages show: of what these list and of its public members."""
    pages = "".join(page.read_text() for page in SITE.rglob("*.md"))
    for path in re.findall(r"auto(?:class|function):: (fenicsx_contact\.\S+)", pages):
        module, _, name = path.rpartition(".")
        thing = getattr(importlib.import_module(module), name)
        members = vars(thing).items() if isinstance(thing, type) else ()
        for each in (thing, *(member for n, member in members if not n.startswith("_"))):
            if text := inspect.getdoc(each):
                yield path, text


def test_docstrings_are_text_that_sphinx_reads():
    """A line is indented deeper than the one before only where a text begins, or in a section."""
    wrong, indent = [], lambda line: len(line) - len(line.lstrip())
    for path, text in documented():
        section, first = False, True  # whether the line before begins a text
        lines = text.splitlines()
        for before, line in zip(lines, lines[1:]):
            if not line or not before:
                first = not before
                continue
            named = re.fullmatch(r"(Args|Attributes|Raises|Returns|Yields):", before)
            section = bool(named) or (section and indent(before) > 0)
            item = first or named or (section and indent(before) == 4)
            if indent(line) > indent(before) and not item and not re.match(r" *[-*] ", before):
                wrong.append((path, line))
            first = False
    assert not wrong


NODE = shutil.which("node")


@pytest.mark.skipif(not NODE, reason="no node to run JavaScript")
def test_what_plays_computes_what_the_package_does(tmp_path, monkeypatch):
    """The falls of the first lesson, by the page's JavaScript and by the package."""
    monkeypatch.chdir(tmp_path)
    names = learn(LESSONS[0])
    script = f"""
        const P = require({json.dumps(str(SITE / "static" / "one_point.js"))});
        const set = {{ theta: 0.5, mu: 0, dt: 0.01, m: 2, until: 1.5, v_t: 0 }};
        const gap = P.fall({{ ...set, law: "gap", e: 0 }});
        const rest = P.fall({{ ...set, law: "velocity", e: 0 }});
        const hit = P.newton({{ free_n: 1.5, free_t: 1, allowed: -0.75, W: 0.5, mu: 0.3, rho: 9,
                                start: 3 }}).at(-1);
        const line = (rows) => rows.map((r) => r.y);
        console.log(JSON.stringify({{ gap: line(gap), rest: line(rest), hit }}));
    """
    run = subprocess.run([NODE, "-e", script], capture_output=True, text=True, check=True)
    found = json.loads(run.stdout)
    assert found["gap"] == pytest.approx(list(names["gap"]["height"]), abs=1e-9)
    uniform = names["fall"]("velocity")
    steps = np.flatnonzero(np.diff(uniform.time, prepend=-1.0))  # without percussions
    assert found["rest"] == pytest.approx(list(uniform["height"][steps]), abs=1e-9)
    hit = found["hit"]  # by hand: lam = -(1.5 + 0.75) m, tau = mu |lam|, w_t = 1 - tau/m
    assert hit["lam"] == pytest.approx(-4.5) and hit["tau"] == pytest.approx(1.35)
    assert hit["w_t"] == pytest.approx(1 - 1.35 / 2)


@pytest.mark.skipif(not NODE, reason="no node to run JavaScript")
def test_what_plays_is_solved_wherever_its_knobs_are():
    """Newton's method ends, with the solution: by cases, for one point."""
    script = f"""
        const P = require({json.dumps(str(SITE / "static" / "one_point.js"))});
        let seed = 1;
        const random = (low, high) => {{
            seed = (seed * 48271) % 2147483647;
            return low + (high - low) * seed / 2147483647;
        }};
        const rows = [];
        for (let i = 0; i < 20000; i++) {{
            const set = {{ free_n: random(-2, 2), free_t: random(-2, 2), W: 1, mu: random(0, 2),
                           rho: 10 ** random(-2, 2), start: random(-4, 4) }};
            set.allowed = -random(0, 1) * set.free_n;
            const iterates = P.newton(set), end = iterates.at(-1);
            const lam = -Math.max(0, set.free_n - set.allowed), b = -set.mu * lam;
            const tau = Math.max(-b, Math.min(b, set.free_t));
            rows.push([Math.abs(end.lam - lam) + Math.abs(end.tau - tau), iterates.length]);
        }}
        console.log(JSON.stringify(rows));
    """
    run = subprocess.run([NODE, "-e", script], capture_output=True, text=True, check=True)
    error, count = np.array(json.loads(run.stdout)).T
    assert error.max() < 1e-9 and count.max() <= 10


# -- the built site -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def site():
    """Built by the command of the README."""
    command = [sys.executable, str(SITE / "build.py")]
    run = subprocess.run(command, cwd=TOP, capture_output=True, text=True, check=False)
    if "No matching distribution" in run.stderr or "Temporary failure" in run.stderr:
        pytest.skip(f"Sphinx cannot be installed here: {run.stderr[-200:]}")
    assert run.returncode == 0, run.stdout + run.stderr
    return TOP / "results" / "site"


class Links(html.parser.HTMLParser):
    """What a page links to and loads, and the places in it that can be linked to."""

    def __init__(self, page):
        super().__init__()
        self.links, self.loads, self.ids = [], [], {""}
        self.feed(page.read_text())

    def handle_starttag(self, tag, attrs):
        of = dict(attrs)
        self.ids.add(of.get("id") or "")
        if tag == "a" and of.get("href"):
            self.links.append(of["href"])
        elif of.get("src") or (tag == "link" and of.get("href")):
            self.loads.append(of.get("src") or of["href"])


@pytest.mark.long
def test_no_link_is_broken_and_nothing_is_loaded_from_elsewhere(site):
    pages = {page: Links(page) for page in site.rglob("*.html")}
    assert len(pages) >= 25
    broken = []
    for page, found in pages.items():
        for link in found.links + found.loads:
            where = urlsplit(link)
            if where.scheme or where.netloc:
                if link in found.loads and where.scheme != "data":
                    broken.append((page.name, "loads", link))
                continue
            target = (page.parent / unquote(where.path)).resolve() if where.path else page
            known = pages[target].ids if target in pages else {"", where.fragment}
            if not target.exists() or unquote(where.fragment) not in known:
                broken.append((page.name, link))
    assert not broken


#: Opens every page in a frame of each width and tells what is wrong with it.
HARNESS = """<!doctype html><meta charset="utf-8"><body><pre id="out">not done</pre><script>
const pages = PAGES, widths = WIDTHS, out = [];
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
(async () => {
  for (const page of pages) for (const width of widths) {
    const frame = document.createElement("iframe"), errors = [];
    frame.style = `width:${width}px;height:900px;border:0`;
    document.body.append(frame);
    const loaded = new Promise((done) => (frame.onload = done));
    frame.src = page;
    await loaded;
    const w = frame.contentWindow, d = w.document;
    w.onerror = (message) => errors.push(String(message));
    d.querySelectorAll("iframe").forEach((f) => (f.loading = "eager"));
    d.querySelectorAll("img").forEach((i) => (i.loading = "eager"));
    if (w.MathJax && w.MathJax.startup) await w.MathJax.startup.promise;
    await wait(150);
    const drawn = [...d.querySelectorAll("canvas")].map((c) => {
      const p = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
      return p.some((v, i) => i % 4 < 3 && p[i + 3 - (i % 4)] > 0 && v < 200);
    });
    out.push({
      page, width, errors, drawn,
      wide: d.documentElement.scrollWidth,
      math: d.querySelectorAll(".math, mjx-container").length,
      mathjax: d.querySelectorAll("mjx-container svg").length,
      merrors: d.querySelectorAll("mjx-merror, [data-mjx-error]").length,
      missing: [...d.images].filter((i) => !i.complete || !i.naturalWidth).map((i) => i.src),
      small: [...d.querySelectorAll("article p")].filter((p) => p.offsetParent &&
        parseFloat(w.getComputedStyle(p).fontSize) < 11).length,
      title: d.title,
    });
    frame.remove();
  }
  document.getElementById("out").textContent = JSON.stringify(out);
})().catch((e) => (document.getElementById("out").textContent = "failed: " + e.stack));
</script>"""


@pytest.fixture(scope="module")
def seen(site, tmp_path_factory):
    """What Chromium says of every page at every width, and what it wrote on its console."""
    if not CHROMIUM:
        pytest.skip("no Chromium here: apt-get install chromium")
    pages = [page.as_uri() for page in sorted(site.rglob("*.html"))]
    folder = tmp_path_factory.mktemp("chromium")
    harness = HARNESS.replace("PAGES", json.dumps(pages)).replace("WIDTHS", json.dumps(WIDTHS))
    (folder / "all.html").write_text(harness)
    flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"]
    flags += ["--disable-web-security", f"--user-data-dir={folder}", "--enable-logging=stderr"]
    flags += ["--window-size=1500,1000", "--virtual-time-budget=600000", "--dump-dom"]
    command = [CHROMIUM, *flags, (folder / "all.html").as_uri()]
    run = subprocess.run(command, capture_output=True, text=True, timeout=580, check=True)
    text = run.stdout.partition('<pre id="out">')[2].partition("</pre>")[0]
    assert text.startswith("["), text
    console = [line for line in run.stderr.splitlines() if "CONSOLE" in line]
    return json.loads(html.unescape(text)), console


@pytest.mark.long
def test_pages_in_chromium(seen):
    pages, console = seen
    assert len(pages) >= 2 * 25
    assert not console
    wide = [(page["page"], page["width"], page["wide"]) for page in pages]
    assert not [each for each in wide if each[2] > each[1]]  # nothing to scroll sideways
    for page in pages:
        assert not page["errors"] and not page["missing"] and not page["merrors"], page
        assert page["mathjax"] >= page["math"] / 2, page  # each in its container
        assert all(page["drawn"]), page
        assert page["title"] and not page["small"], page
    drawn = {Path(page["page"]).stem: page for page in pages if page["drawn"]}
    assert set(drawn) == {"one_point", "box", "thrown", "ironing", "ball"}
    with_math = [page for page in pages if "lessons" in page["page"] or "theory" in page["page"]]
    assert all(page["mathjax"] > 0 for page in with_math)


@pytest.mark.long
def test_notebooks_to_take_along(site):
    """Executed, with pictures, without the solutions."""
    books = sorted((site / "_downloads").rglob("*_notebook.ipynb"))
    assert len(books) == len(LESSONS)
    for path in books:
        cells = json.loads(path.read_text())["cells"]
        outputs = [out for cell in cells for out in cell.get("outputs", [])]
        assert not [out for out in outputs if out["output_type"] == "error"]
        assert any("image/svg+xml" in out.get("data", {}) for out in outputs), path
        assert not any("answer" in "".join(cell["source"]) for cell in cells if "outputs" in cell)


@pytest.mark.long
def test_scenes_are_light(site):
    sizes = {path.name: path.stat().st_size for path in (site / "_static" / "scenes").glob("*")}
    assert len(sizes) == 4 and max(sizes.values()) < 5e6
    assert np.all([page.stat().st_size < 5e6 for page in site.rglob("*.html")])


IN_A_NOTEBOOK = """
import sys
sys.path.insert(0, "SITE")
import nbformat, lessons
from pathlib import Path
from nbclient import NotebookClient
parts = lessons.cells(Path("DEMO").read_text())
new = {"markdown": nbformat.v4.new_markdown_cell, "code": nbformat.v4.new_code_cell}
book = nbformat.v4.new_notebook(cells=[new[kind](text) for kind, text in parts])
NotebookClient(book, timeout=600).execute()
outputs = [out for cell in book.cells for out in cell.get("outputs", [])]
print(sum("image/png" in out.get("data", {}) for out in outputs), "pictures")
"""


@pytest.mark.long
def test_a_demo_in_a_notebook(site, tmp_path):
    """It runs from any folder, and shows its pictures below its cells."""
    venv = TOP / "results" / "site_work" / "venv" / "bin" / "python"
    python = venv if venv.exists() else sys.executable
    demo = TOP / "demos" / "own_laws.py"
    script = IN_A_NOTEBOOK.replace("SITE", str(SITE)).replace("DEMO", str(demo))
    run = subprocess.run(
        [python, "-c", script],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(TOP)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert int(run.stdout.split()[-2]) >= 1


@pytest.mark.parametrize("page", sorted(SITE.rglob("*.md")), ids=lambda page: page.stem)
def test_links_stay_on_the_site(page):
    """The site's builder complains of others, which is known only after ten minutes."""
    for link in re.findall(r"\]\(([^)#:\s]+)[^)]*\)", page.read_text()):
        assert SITE in (page.parent / link).resolve().parents, link
