#!/usr/bin/env python3
"""Relative links of documents lead to files that exist, and every document has a chapter.

    links.py FOLDER    a folder with README.md and docs, of the source or installed

A source has jobs/site.py, whose chapters must hold every document of docs.
"""
import importlib.util
import pathlib
import re
import sys

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.*)$", re.M)
CODE = re.compile(r"^```.*?^```", re.M | re.S)


def anchors_of(path):
    """Names of the headings, as GitHub and mkdocs make them."""
    text = CODE.sub("", path.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
            for heading in HEADING.findall(text)}


def dead_links(document):
    for link in LINK.findall(CODE.sub("", document.read_text(encoding="utf-8"))):
        if re.match(r"[a-z]+:", link):
            continue  # another site
        place, _, anchor = link.partition("#")
        target = document.parent / place if place else document
        if not target.exists():
            yield f"{document}: {link}: there is no such file"
        elif anchor and target.suffix == ".md" and anchor not in anchors_of(target):
            yield f"{document}: {link}: has no such heading"


def without_chapter(root):
    site = root / "jobs/site.py"
    if not site.is_file():
        return
    spec = importlib.util.spec_from_file_location("site_of_trackbed", site)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    listed = {name for names in module.CHAPTERS.values() for name in names}
    documents = [*(root / "docs").glob("*.md"), *(root / "docs/studies").glob("*/README.md")]
    for document in sorted(documents):
        name = document.relative_to(root / "docs").with_suffix("").as_posix()
        if name not in listed:
            yield f"{document}: is in no chapter of jobs/site.py"


def main():
    root = pathlib.Path(sys.argv[1])
    documents = [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    found = [line for document in documents for line in dead_links(document)]
    found += without_chapter(root)
    print("\n".join(found) or f"no dead link in {len(documents)} documents")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
