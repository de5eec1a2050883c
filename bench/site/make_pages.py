"""Writes the sources of the site into SITE: pages/, mkdocs.yml, Doxyfile. make_pages.py SITE

The tree of the documents stays as it is, so that their links hold. New pages: one for each shipped
scene, from its run in SITE/runs, and the Python interface, from its stubs and docstrings.
"""

import ast
import inspect
import json
import pathlib
import re
import shutil
import sys

import bipot

ROOT = pathlib.Path(__file__).parents[2]
SITE = pathlib.Path(sys.argv[1])
PAGES = SITE / "pages"
PACKAGE = ROOT / "bench" / "python" / "bipot"


def copy_documents():
    """README, CHANGELOG, data, and every other file that a page links to."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(ROOT / "data", PAGES / "data", ignore=shutil.ignore_patterns("fuzz/*/*", "[123]d_*.hdf5", "rows.csv"))
    for name in ("README.md", "CHANGELOG.md"):
        shutil.copy(ROOT / name, PAGES / name)
    # mkdocs leaves folders out whose names begin with a dot.
    (PAGES / "github").mkdir()
    for page in (ROOT / ".github").glob("*.md"):
        shutil.copy(page, PAGES / "github" / page.name)
    readme = (PAGES / "README.md").read_text(encoding="utf-8")
    (PAGES / "README.md").write_text(readme.replace("](.github/", "](github/"), encoding="utf-8")
    for page in list(PAGES.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#\s:]+)[^):]*\)", text):
            place = (page.parent / target).resolve()
            inside = place.relative_to(PAGES.resolve()) if place.is_relative_to(PAGES.resolve()) else None
            if inside is None or place.exists():
                continue
            source = ROOT / inside
            if source.is_dir():  # a folder of programs: its list of files
                place.mkdir(parents=True)
                for file in sorted(source.iterdir()):
                    if file.is_file():
                        shutil.copy(file, place / file.name)
                rows = "".join(f"* [{file.name}]({file.name})\n" for file in sorted(place.iterdir()))
                (place / "README.md").write_text(f"# {source.name}\n\n{rows}", encoding="utf-8")
            else:
                place.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, place)
    for page in PAGES.rglob("*.md"):
        text = page.read_text(encoding="utf-8")
        # mkdocs wants pages, not folders, in links; a reader of the site sees no files .md.
        text = re.sub(r"\]\(([^)#:\s]+/)?(examples)\)", r"](\1\2/README.md)", text)
        text = re.sub(r"\[(\w+)\.md\b", lambda link: f"[{link[1].replace('_', ' ')}", text)
        text = re.sub(r"^(```\w+) .*", r"\1", text, flags=re.M)  # of "```sh runs" it wants the language alone
        page.write_text(text, encoding="utf-8")


def scene_page(name, run):
    """Picture, player and numbers of one run. The title, for the menu."""
    summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    folder = PAGES / "scenes" / name
    folder.mkdir(parents=True)
    picture = next((p for p in ("forces.png", "slice.png", "forces.svg") if (run / p).exists()), None)
    for file in filter(None, ("index.html", picture)):
        shutil.copy(run / file, folder / ("play.html" if file == "index.html" else file))
    bodies = "disks" if "disks" in summary else "spheres"
    energy = summary["energy"]
    rows = [
        ("end", f"{summary['status']}: {summary['steps']} of {summary['steps_planned']} steps, "
                f"t = {summary['time']:.4g} s"),
        ("steps solved to the tolerance", str(summary["steps_converged"])),
        (bodies, str(summary.get(bodies, summary.get("bodies", "")))),
        ("solver, tolerance", f"{summary['solver']}, {summary['tol']:g}"),
        ("contacts, mean and most", f"{summary['contacts_mean']:.1f}, {summary['contacts_max']}"),
        ("iterations, mean and most", f"{summary['iterations_mean']:.1f}, {summary['iterations_max']}"),
        ("largest ε, largest η", f"{summary['epsilon']:.2e}, {summary['eta']:.2e}"),
        ("largest penetration", f"{summary['penetration']:.3e} m"),
        ("lost to friction, to shocks", f"{energy['friction_loss']:.4e} J, {energy['shock_loss']:.4e} J"),
    ]
    table = "".join(f"| {key} | {value} |\n" for key, value in rows)
    scene = (ROOT / "data" / "scenes" / f"{name}.toml").read_text(encoding="utf-8")
    (folder / "README.md").write_text(
        f"# {summary['title']}\n\n`bipot run {name}`\n\n"
        + '<iframe src="play.html" title="The run" width="100%" height="940" style="border:0"></iframe>\n\n'
        + "[The player alone](play.html)\n\n"
        + (f"![Forces at the end]({picture})\n\n" if picture else "")
        + f"| of this run | |\n| --- | --- |\n{table}\n## Scene file\n\n```toml\n{scene}```\n",
        encoding="utf-8",
    )
    return summary["title"]


def definitions():
    """Classes and functions of the stub and of the Python files, by name."""
    found = {}
    for file in (*PACKAGE.glob("*.py"), PACKAGE / "_bipot.pyi"):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                found.setdefault(node.name, node)
    return found


def signature(node):
    """The definition without its body and its decorators."""
    head = ast.FunctionDef(
        name=node.name, args=node.args, returns=node.returns, body=[ast.Expr(ast.Constant(...))],
        decorator_list=[], lineno=0, type_comment=None,
    )
    return ast.unparse(ast.fix_missing_locations(head)).replace(":\n    ...", "")


def described(thing):
    """The docstring; of native functions without the signature that pybind11 puts before it."""
    text = inspect.getdoc(thing) or ""
    return re.sub(r"\A\w+\(.*?\) -> [^\n]*\n*", "", text, flags=re.S).strip()


def prose(text):
    """Markdown of a docstring: indented blocks are code, `name: ...` begins a line, pages are links."""
    blocks = []
    for block in re.split(r"\n\s*\n", text):
        lines = block.split("\n")
        if all(line.startswith("    ") for line in lines):
            blocks.append(block)
            continue
        block = lines[0]
        for before, line in zip(lines, lines[1:]):
            named = before.endswith(".") and re.match(r"[\w, ]+( \[.*?\])?: ", line)
            new = not line.startswith(" ") and (named or before.startswith(" "))
            block += ("  \n" if new else " ") + line.strip()
        parts = block.split("`")
        parts[::2] = [re.sub(r"([*_\[\]])", r"\\\1", part).replace("<", "&lt;") for part in parts[::2]]
        blocks.append(re.sub(r"data/manual/\w+/(\w+)\.md", r"[\1](\g<0>)", "`".join(parts)))
    return "\n\n".join(blocks) + "\n"


def members(node, nodes):
    """Those of the definition of a class, then of its bases."""
    bases = [base.id for base in node.bases if isinstance(base, ast.Name) and base.id in nodes]
    return [*node.body, *(member for base in bases for member in members(nodes[base], nodes))]


def python_page():
    nodes = definitions()
    parts = [f"# The Python module\n\n{prose(inspect.getdoc(bipot))}"]
    for name in sorted(bipot.__all__):
        thing, node = getattr(bipot, name), nodes[name]
        parts.append(f"## {name}\n")
        if isinstance(node, ast.FunctionDef):
            parts.append(f"```python\n{signature(node)}\n```\n")
        parts.append(prose(described(thing)))
        fields, methods = [], []
        for member in members(node, nodes) if isinstance(node, ast.ClassDef) else []:
            field = isinstance(member, ast.AnnAssign)
            if not field and not isinstance(member, ast.FunctionDef):
                continue
            title = member.target.id if field else member.name
            if title != "__init__" and title[0] == "_":
                continue
            if title == "__init__" and "native" in ast.unparse(member.args):
                continue  # made by a function, not by users
            text = prose(described(getattr(thing, title, None))) if title != "__init__" else ""
            if field or any(isinstance(d, ast.Name) and d.id == "property" for d in member.decorator_list):
                kind = ast.unparse(member.annotation if field else member.returns)
                kind = re.sub(r"Final\[(.*)\]", r"\1", kind)
                fields.append(f"* `{title}: {kind}`\u2002{text}")
            else:
                methods.append(f"```python\n{signature(member)}\n```\n\n{text}")
        parts += ["".join(fields), *methods]
    (PAGES / "python.md").write_text("\n".join(parts), encoding="utf-8")


def menu(titles):
    """The nav: the headings and links of the manual's first page."""
    nav, group = [{"Bipot": "README.md"}], None
    for line in (ROOT / "data" / "manual" / "README.md").read_text(encoding="utf-8").split("\n"):
        if line.startswith("## "):
            group = []
            nav.append({line[3:]: group})
        for title, target in re.findall(r"\[([^\]]+)\]\(([^)#]+\.md)\)", line):
            title = title[0].upper() + title[1:]  # of `auto` the mark is first
            group.append({title.replace("`", ""): str(pathlib.PurePosixPath("data/manual") / target)})
    resolved = json.dumps(nav).replace("data/manual/../", "data/")
    scenes = [{title: f"scenes/{name}/README.md"} for name, title in titles.items()]
    return [*json.loads(resolved), {"Scenes": scenes}, {"Python module": "python.md"}, {"Changes": "CHANGELOG.md"}]


def main():
    copy_documents()
    titles = {
        run.name: scene_page(run.name, run)
        for run in sorted((SITE / "runs").iterdir())
        if (ROOT / "data" / "scenes" / f"{run.name}.toml").exists()
    }
    python_page()
    config = {
        "site_name": "Bipot",
        "docs_dir": "pages",
        "site_dir": "html",
        "theme": {
            "name": "material",
            "font": False,  # the reader's own: nothing is loaded from elsewhere
            "features": ["navigation.top"],
            # As the players in the pages: what the reader's system wants.
            "palette": [
                {"media": f"(prefers-color-scheme: {now})", "scheme": scheme,
                 "toggle": {"icon": f"material/{icon}", "name": other}}
                for now, scheme, icon, other in (("light", "default", "weather-night", "Dark"),
                                                 ("dark", "slate", "weather-sunny", "Light"))
            ],
            "icon": {"logo": "material/dots-hexagon"},
        },
        "plugins": ["search"],
        "extra_css": ["site.css"],
        "markdown_extensions": ["tables", "fenced_code", "toc",
                                {"codehilite": {"guess_lang": False, "css_class": "highlight"}}],
        "use_directory_urls": False,
        "nav": [*menu(titles), {"C++ headers": "cpp.md"}, {"Contributing": "github/CONTRIBUTING.md"}],
    }
    (PAGES / "cpp.md").write_text(
        "# The C++ library\n\n[The installed headers](cpp/index.html), and [how to use them]"
        "(data/manual/how_to/use_the_library.md).\n", encoding="utf-8")
    (PAGES / "site.css").write_text(".md-typeset pre > code { white-space: pre-wrap; font-size: .75em; }\n"
        ".md-typeset table:not([class]) :is(th, td) { padding: .5em .8em; min-width: 0; }\n"
        ".md-typeset td code { word-break: normal; }\n"
        "[data-md-color-scheme=slate] { --md-typeset-a-color: #8ab8ec; }\n", encoding="utf-8")
    (PAGES / "cpp").mkdir()
    (PAGES / "cpp" / "index.html").write_text("", encoding="utf-8")  # Doxygen's takes its place
    (SITE / "mkdocs.yml").write_text(json.dumps(config, indent=2), encoding="utf-8")
    (SITE / "main.dox").write_text(
        '/** @mainpage The C++ library\n<a href="annotated.html">Classes</a>, <a href="files.html">files</a>, '
        'and the <a href="../index.html">manual</a>. */\n', encoding="utf-8")
    (SITE / "Doxyfile").write_text(
        'PROJECT_NAME = "Bipot"\nINPUT = library/include/bipot main.dox\nRECURSIVE = YES\nOUTPUT_DIRECTORY = cpp\n'
        "GENERATE_LATEX = NO\nEXTRACT_ALL = YES\nFULL_PATH_NAMES = YES\nSTRIP_FROM_PATH = library/include/bipot\n"
        "STRIP_FROM_INC_PATH = library/include/bipot\n"
        "HAVE_DOT = NO\nSEARCHENGINE = YES\nQUIET = YES\nFILE_PATTERNS = *.h\nJAVADOC_AUTOBRIEF = YES\n",
        encoding="utf-8")


main()
