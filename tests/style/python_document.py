#!/usr/bin/env python3
"""Checks that docs/python.md has the signatures and descriptions of what the Python package has for
scripts, and that it has every module that an example in docs imports.

    python_document.py SOURCE_FOLDER            compares, shows the first differences
    python_document.py SOURCE_FOLDER --write    writes it (CMake target `docs`)

The sources are read, not imported: no module of Python is needed.
"""
import ast
import difflib
import pathlib
import re
import sys
import textwrap

DOCUMENT = "docs/python.md"
COLUMNS = 100
SHOWN_LINES = 40
# Names for scripts, by their modules; "": those that the package exports itself.
NAMES = {
    "": (),
    "read": ("Chains", "Bonds", "Stones", "summary", "rows_of_stage", "time_in"),
    "signals": ("step_of", "LowPass", "spectrum", "peak_near", "energies", "third_octaves",
                "levels", "weighting_wk", "weighting_wb", "weighted", "weighted_rms", "transient",
                "continuous_comfort", "mean_comfort"),
    "measured": ("Signal", "load", "acceleration", "detrended"),
    "curves": ("Curve", "known", "of_run", "of_runs", "of_file", "deviation"),
    "frequencies": ("of_train", "of_passage"),
    "support": ("Support", "of"),
    "geometry": ("Level", "load", "bands_of", "twist", "worst_window", "classes", "numbers"),
    "settlement.laws": ("shenton", "Varandas", "li_selig", "law", "Fit", "fit"),
    "monitor.displacement": ("Reconstruction", "reconstruct", "noise_of"),
    "monitor.indicators": ("band", "indicator"),
    "monitor.greens": ("Wheels", "Kernel", "load", "superposed"),
    "monitor.inverse": ("Forces", "Arrival", "evaluate", "Irregularity", "irregularity"),
}
HEAD = """# Python package
`trackbed_post` reads results as arrays with units, and has the functions behind figures and tables:
filters, spectra, track geometry, monitoring. [postproc.md](postproc.md) states where the package
is, has examples, and describes the commands and the datasets with their units and signs. Names in
capitals are constants of the module. What is not listed serves the commands and may change.
`tests/style/python_document.py` writes this document.
"""


def text_of(node):
    """The description of a module, class or function, with its paragraphs."""
    return ast.get_docstring(node) or ""


def signature(node):
    """name(arguments) -> type, an argument in each line if it is too long for one."""
    end = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    line = f"{node.name}({ast.unparse(node.args)}){end}"
    if len(line) <= COLUMNS:
        return line
    given = node.args
    plain = [*given.posonlyargs, *given.args]
    values = [None] * (len(plain) - len(given.defaults)) + given.defaults
    words = [ast.unparse(ast.arguments([], [one], None, [], [], None, [value] if value else []))
             for one, value in zip(plain, values)]
    words += [f"*{ast.unparse(given.vararg)}"] if given.vararg else []
    words += ["*"] if given.kwonlyargs and not given.vararg else []
    words += [ast.unparse(one) + (f"={ast.unparse(value)}" if value else "")
              for one, value in zip(given.kwonlyargs, given.kw_defaults)]
    return f"{node.name}(\n    " + ",\n    ".join(words) + f"){end}"


def members(node, lines):
    """A class with its fields as they are in the source, and their comments."""
    fields = [part for part in node.body
              if isinstance(part, ast.AnnAssign) and not part.target.id.startswith("_")]
    shown = [line for part in fields for line in lines[part.lineno - 1:part.end_lineno]]
    return "\n".join([f"class {node.name}", *shown])


def methods(node):
    for part in node.body:
        if isinstance(part, ast.FunctionDef) and text_of(part) and (
                not part.name.startswith("_") or part.name == "__call__"):
            words = "" if any(ast.unparse(one) == "property" for one in part.decorator_list) else (
                "(" + ast.unparse(part.args).removeprefix("self").removeprefix(", ") + ")")
            yield textwrap.fill(f"- `{part.name}{words}`: {' '.join(text_of(part).split())}",
                                COLUMNS, subsequent_indent="  ", break_on_hyphens=False)


def entry(node, lines):
    is_class = isinstance(node, ast.ClassDef)
    code = members(node, lines) if is_class else signature(node)
    parts = [f"### {node.name}", f"```python\n{code}\n```", text_of(node)]
    if is_class and (listed := list(methods(node))):
        parts.append("\n".join(listed))
    return "\n".join(parts[:2]) + "\n" + "\n\n".join(parts[2:]) + "\n"


def parsed(package, name):
    path = package / (name.replace(".", "/") or "__init__")
    source = path.with_suffix(".py").read_text(encoding="utf-8")
    return ast.parse(source), source.splitlines()


def exported(tree):
    """The names in `__all__`."""
    found, = (node.value for node in tree.body
              if isinstance(node, ast.Assign) and node.targets[0].id == "__all__")
    return ast.literal_eval(found)


def section(package, module):
    """A module with the names of NAMES; those that the package exports are in `read`."""
    own, _ = parsed(package, module)
    tree, lines = parsed(package, module or "read")
    nodes = {node.name: node for node in tree.body
             if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and text_of(node)}
    wanted = NAMES[module] or exported(own)
    if absent := [name for name in wanted if name not in nodes]:
        raise SystemExit(f"{module or 'trackbed_post'} has no description of {', '.join(absent)}")
    yield (f"## {'.'.join(filter(None, ('trackbed_post', module)))}\n"
           f"{text_of(own).partition(chr(10) * 2)[0]}\n")
    yield from (entry(nodes[name], lines) for name in wanted)


def written_from(root):
    package = root / "postproc/trackbed_post"
    return "\n".join([HEAD, *(part for module in NAMES for part in section(package, module))])


def imported(root):
    """Modules that the examples of the documents import."""
    for document in sorted((root / "docs").glob("*.md")):
        for block in re.findall(r"^```python\n(.*?)^```", document.read_text(encoding="utf-8"),
                                re.M | re.S):
            if document.name == pathlib.Path(DOCUMENT).name:
                continue
            for node in ast.walk(ast.parse(block)):
                if isinstance(node, ast.ImportFrom) and node.module.startswith("trackbed_post"):
                    yield from (f"{node.module}.{one.name}" for one in node.names)


def check(root):
    written = (root / DOCUMENT).read_text(encoding="utf-8") if (root / DOCUMENT).is_file() else ""
    problems, given = [], written_from(root)
    if written != given:
        lines = difflib.unified_diff(written.splitlines(), given.splitlines(), DOCUMENT,
                                     "the package", lineterm="", n=0)
        problems = [f"{DOCUMENT} is out of date; call {pathlib.Path(__file__).name} . --write",
                    *list(lines)[:SHOWN_LINES]]
    return problems + [f"{DOCUMENT} lacks the module {name}, which an example imports"
                       for name in imported(root)
                       if name.removeprefix("trackbed_post.") not in NAMES]


def main():
    root = pathlib.Path(sys.argv[1])
    if "--write" in sys.argv[2:]:
        (root / DOCUMENT).write_text(written_from(root), encoding="utf-8")
    problems = check(root)
    print("\n".join(problems) or f"{DOCUMENT} agrees with the package")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
