#!/usr/bin/env python3
"""Builds the web site of the documents and of all decks, with a search, and checks every link.

    site.py FOLDER [PROGRAM]

With PROGRAM (trackbed), the site has a drawing of the model of each deck. The states of other runs
that a deck begins with need not exist: they are not drawn.
Writes FOLDER/documents (what mkdocs reads) and FOLDER/site, whose index.html opens without a
server; only the search needs one (`python3 -m http.server -d FOLDER/site`). Needs mkdocs (Debian:
mkdocs, mkdocs-material). Ends with 1 and a list if a link leads nowhere.
"""
import html.parser
import json
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
# Chapters of the navigation: title -> documents of docs/.
CHAPTERS = {
    "First steps": ("tutorial", "gallery", "cookbook", "troubleshooting", "limits"),
    "User guide": ("running", "track", "bed", "stones", "ground", "solid_track", "shapes",
                   "breakage", "bonds", "settlement", "bridge", "laboratory", "postproc",
                   "monitoring"),
    "Studies": ("studies/netirail/README", "studies/shi/README", "studies/demfem/README",
                "studies/chen/README", "studies/crossing/README"),
    "Reference": ("input", "python", "checkpoint", "glossary", "verification", "theory", "scaling",
                  "reliability"),
    "Development": ("architecture", "contributing", "comparison"),
}
TITLES = {"input": "Parameters of decks"}
CONFIG = {"site_name": "trackbed", "theme": {"name": "material", "font": False},
          "docs_dir": "documents", "site_dir": "site", "use_directory_urls": False,
          "plugins": ["search"], "extra_css": ["site.css"],
          "markdown_extensions": ["tables", "fenced_code", "toc", "md_in_html"]}
# The table of decks fits into a window of 1000 pixels: words are wrapped in all of its columns.
STYLE = """
.decks table:not([class]) { display: table; table-layout: fixed; width: 100%; }
.decks .md-typeset__table { display: block; padding: 0; }
.decks table:not([class]) :is(th, td) { min-width: 0; padding: .6em; overflow-wrap: anywhere; }
.decks :is(th, td):nth-child(1) { width: 13rem; }
.decks :is(th, td):nth-child(3) { width: 5rem; }
.decks :is(th, td):nth-child(4) { width: 9rem; }
.decks img { max-width: 100%; max-height: 6rem; }
"""
WITHOUT = ("bed.cell=", "start=")  # states of other runs, which are not drawn
SENTENCE = re.compile(r"(?:(?<!min)\.|[;:])(?: |$)")  # "min" is an abbreviation
LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")


def head_of(deck):
    """Purpose, source, ranks and run time of the comment at the begin of a deck."""
    found, key = {}, ""
    for line in deck.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        text = line.lstrip("#").strip()
        name, colon, rest = text.partition(":")
        if colon and name in ("Purpose", "Source", "Ranks", "Run time"):
            key, found[name] = name, rest.strip()
        elif key:
            found[key] += " " + text
    return found


def document_of_deck(deck):
    """Path of a deck's document within the site."""
    return pathlib.Path("decks") / deck.relative_to(ROOT / "inputs").with_suffix(".md")


def target_of(link, document):
    """Where a link of a document leads in the site, as seen from `document` (both within the
    site), or None: a file that is not part of the site."""
    path, hash_, anchor = link.partition("#")
    home = ROOT if document == pathlib.Path("index.md") else (DOCS / document).parent
    aim = (home / path).resolve() if path else None
    if aim is None:
        return link
    if aim.is_relative_to(ROOT / "inputs"):
        where = document_of_deck(aim) if aim.suffix == ".toml" else pathlib.Path("decks/index.md")
    elif aim == ROOT / "CHANGELOG.md":
        where = pathlib.Path("changelog.md")
    elif aim == ROOT / "README.md":
        where = pathlib.Path("index.md")
    elif aim == DOCS / "decisions":
        where = pathlib.Path("decisions/index.md")
    elif aim.is_relative_to(DOCS):
        where = aim.relative_to(DOCS)
    else:
        return None
    up = "../" * (len(document.parts) - 1)
    return f"{up}{where.as_posix()}{hash_}{anchor}"


def adapted(text, document):
    """A document for the site: links to files outside of it become plain text."""
    def replace(match):
        words, link = match.groups()
        if urllib.parse.urlsplit(link).scheme:
            return match[0]
        target = target_of(link, document)
        return f"[{words}]({target})" if target else words
    return LINK.sub(replace, text)


def title_of(path):
    """The first heading of a document."""
    found = re.search(r"^#+ +(.*)$", path.read_text(encoding="utf-8"), re.M)
    return found[1].strip("` ") if found else path.stem


def without_empty_column(text):
    """A document without sections does not need the column of its table of contents."""
    return text if re.search(r"^## ", text, re.M) else f"---\nhide: [toc]\n---\n{text}"


def write_documents(documents):
    put = {pathlib.Path("index.md"): ROOT / "README.md",
           pathlib.Path("changelog.md"): ROOT / "CHANGELOG.md"}
    put |= {path.relative_to(DOCS): path for path in DOCS.rglob("*.md")}
    for document, source in put.items():
        (documents / document).parent.mkdir(parents=True, exist_ok=True)
        text = adapted(source.read_text(encoding="utf-8"), document)
        (documents / document).write_text(without_empty_column(text), encoding="utf-8")
    shutil.copytree(DOCS / "images", documents / "images")
    shutil.copytree(DOCS / "studies", documents / "studies", dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns("*.md"))
    shutil.copy(DOCS / "input.schema.json", documents)
    listed = sorted(path for path in (DOCS / "decisions").glob("*.md"))
    (documents / "decisions/index.md").write_text(
        "# Decisions\n" + "".join(f"- [{title_of(path)}]({path.name})\n" for path in listed),
        encoding="utf-8")


def drawing_of(deck, program, document):
    """(name of the drawing written beside the document of a deck, why there is none)."""
    file, problem = document.with_suffix(".svg"), ""
    for changes in ((), WITHOUT):
        ran = subprocess.run([program, "check", deck, *changes, "--draw", file], check=False,
                             capture_output=True, text=True)
        if file.is_file():
            return file.name, ""
        problem = problem or ran.stderr.strip().partition("\n")[0]
    return "", f"not drawn: {problem}".replace(f"{ROOT}/", "").replace("|", "\\|")


def row_of(name, head, own, drawing, problem):
    """The row of a deck: name and drawing, purpose, ranks, run time without details."""
    shown = f"[{name}]({own})"
    if drawing:
        beside = pathlib.PurePosixPath(own).with_name(drawing)
        shown += f"<br>[![Model of {name}]({beside})]({own})"
    elif problem:
        shown += f"<br>{problem}"
    purpose, ranks, time = (head.get(key, "").replace("|", "\\|")
                            for key in ("Purpose", "Ranks", "Run time"))
    ranks, time = (SENTENCE.split(text)[0] for text in (ranks, time))
    return f"| {shown} | {purpose} | {ranks} | {time} |"


def write_decks(documents, program):
    """A document for each deck, a table of all, and their drawings."""
    rows = ["# Decks\n", '<div class="decks" markdown="1">\n',
            "| deck | purpose | ranks | run time |", "|---|---|---|---|"]
    for deck in sorted((ROOT / "inputs").rglob("*.toml")):
        name, head = deck.relative_to(ROOT).as_posix(), head_of(deck)
        document = documents / document_of_deck(deck)
        document.parent.mkdir(parents=True, exist_ok=True)
        text = deck.read_text(encoding="utf-8")
        drawing, problem = drawing_of(deck, program, document) if program else ("", "")
        shown = f"![Model of {name}]({drawing})\n\n" if drawing else ""
        document.write_text(f"# {name}\n\n{head.get('Purpose', '')}\n\n{shown}"
                            f"```toml\n{text}```\n", encoding="utf-8")
        own = document_of_deck(deck).relative_to("decks").as_posix()
        rows.append(row_of(name, head, own, drawing, problem))
    (documents / "decks/index.md").write_text(
        without_empty_column("\n".join([*rows, "\n</div>\n"])), encoding="utf-8")
    (documents / "site.css").write_text(STYLE, encoding="utf-8")


def navigation(documents):
    """Chapters of those documents that exist; every other document is reached by links."""
    chapters = [{"trackbed": "index.md"}]
    for chapter, names in CHAPTERS.items():
        chapters.append({chapter: [
            {TITLES.get(name, title_of(documents / f"{name}.md")): f"{name}.md"}
            for name in names if (documents / f"{name}.md").is_file()]})
    chapters[-1]["Development"] += [{"Decisions": "decisions/index.md"},
                                    {"Changes": "changelog.md"}]
    chapters.insert(3, {"Decks": "decks/index.md"})
    return chapters


class Hypertext(html.parser.HTMLParser):
    """Links and names of a built document."""

    def __init__(self, text):
        super().__init__()
        self.links, self.names = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name == "id" or (tag == "a" and name == "name"):
                self.names.add(value)


def dead_links(site):
    """(document, link) of each link to a document, picture or place that the site does not have."""
    built = {path: Hypertext(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    for path, document in built.items():
        if path.name in ("404.html", "search.html"):
            continue  # their links begin at the root of a server
        for link in document.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc or link in ("#", ".."):
                continue
            aim = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if aim.is_dir():
                aim = aim / "index.html"
            if not aim.is_file() or (parts.fragment and aim in built
                                     and parts.fragment not in built[aim].names):
                yield path.relative_to(site), link


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: site.py FOLDER [PROGRAM]")
    folder = pathlib.Path(sys.argv[1]).resolve()
    documents = folder / "documents"
    shutil.rmtree(documents, ignore_errors=True)
    write_documents(documents)
    write_decks(documents, pathlib.Path(sys.argv[2]).resolve() if sys.argv[2:] else None)
    # JSON is YAML.
    (folder / "mkdocs.yml").write_text(json.dumps({**CONFIG, "nav": navigation(documents)}),
                                       encoding="utf-8")
    ran = subprocess.run(["mkdocs", "build", "-q", "--clean", "-f", folder / "mkdocs.yml"],
                         check=False)
    if ran.returncode:
        sys.exit(ran.returncode)
    dead = sorted(set(dead_links(folder / "site")))
    for document, link in dead:
        print(f"{document}: {link} leads nowhere", file=sys.stderr)
    count = len(list((folder / "site").rglob("*.html")))
    print(f"{folder / 'site/index.html'}: {count} documents, {len(dead)} dead links")
    sys.exit(1 if dead else 0)


if __name__ == "__main__":
    main()
