#!/usr/bin/env python3
"""Checks that docs/input.md, docs/input.schema.json and the kinds of stages in docs/glossary.md
equal the output of the program.

    generated_docs.py PROGRAM SOURCE_FOLDER            compares, shows the first differences
    generated_docs.py PROGRAM SOURCE_FOLDER --write    writes them (CMake target `docs`)
"""
import difflib
import json
import pathlib
import re
import subprocess
import sys

DOCUMENTS = {"docs/input.md": "describe all", "docs/input.schema.json": "schema"}
SHOWN_LINES = 40


def output_of(program, command):
    run = subprocess.run([program, *command.split()], capture_output=True, text=True, check=False)
    if run.returncode or not run.stdout:
        raise SystemExit(f"{program} {command} ended with {run.returncode}: {run.stderr}")
    return run.stdout


def differences(document, output, path):
    written = path.read_text(encoding="utf-8") if path.exists() else ""
    if written == output:
        return []
    lines = difflib.unified_diff(written.splitlines(), output.splitlines(), document, "the program",
                                 lineterm="", n=0)
    return [f"{document} is out of date; build the target `docs` and commit:",
            *list(lines)[:SHOWN_LINES]]


def with_stage_kinds(glossary, schema):
    """The glossary with the kinds of stages that the schema lists."""
    kinds = json.loads(schema)["properties"]["stage"]["items"]["properties"]["kind"]["enum"]
    pattern = r"(?m)^(\| stage \| [^|:]*: ).*( \|)$"
    if len(re.findall(pattern, glossary)) != 1:
        raise SystemExit("docs/glossary.md has no row `| stage | ...: kinds |`")
    return re.sub(pattern, lambda row: row[1] + ", ".join(kinds) + row[2], glossary)


def main():
    program, root, write = sys.argv[1], pathlib.Path(sys.argv[2]), "--write" in sys.argv[3:]
    problems = []
    outputs = {document: output_of(program, command) for document, command in DOCUMENTS.items()}
    glossary = "docs/glossary.md"
    outputs[glossary] = with_stage_kinds((root / glossary).read_text(encoding="utf-8"),
                                         outputs["docs/input.schema.json"])
    for document, output in outputs.items():
        if document.endswith(".json"):
            json.loads(output)  # raises if it is not JSON
        if write:
            (root / document).write_text(output, encoding="utf-8")
        problems += differences(document, output, root / document)
    print("\n".join(problems) or "the documents agree with the program")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
