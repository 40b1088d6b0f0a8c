"""Each check of this folder finds its kind of breach, and passes a tree without one."""
import pathlib
import re
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import format as layout  # noqa: E402
import generated_docs  # noqa: E402
import glossary  # noqa: E402
import layering  # noqa: E402
import links  # noqa: E402
import python_document  # noqa: E402
import readme  # noqa: E402
import recipe  # noqa: E402
import spelling  # noqa: E402
import troubleshooting  # noqa: E402
import typed  # noqa: E402
import words  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "verify"))
import table as verification  # noqa: E402

TABLE = """
| module | may include | library kept inside | what it is for |
|---|---|---|---|
| core | | | words |
| par | core | mpi | ranks |
| dem | core par | | stones |

| sub-module | may include | what it is for |
|---|---|---|
| dem/law | | laws |
| dem/search | law | lists |
"""
HEAD = "# Purpose: x\n# Source: y\n# Ranks: 2\n# Run time: 1 s\n"


@pytest.fixture(name="tree_with")
def make_tree(tmp_path):
    def make(**files):
        every = {"docs/architecture.md": TABLE, "src/core/a.cpp": "#include <vector>\n",
                 "src/par/b.cpp": '#include <mpi.h>\n\n#include "trackbed/core/a.hpp"\n',
                 "inputs/a.toml": HEAD, ".clang-format": "BasedOnStyle: Google\n"}
        every.update({name.replace("__", "/").replace("_D", "."): text
                      for name, text in files.items()})
        for name, text in every.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path
    return make


def test_sound_tree_passes(tree_with):
    root = tree_with()
    assert layering.check(root) == ([], 3)
    assert words.check(root) == ([], 1)
    assert layout.check(root)[0] == 0


@pytest.mark.parametrize("name, text, expected", [
    ("src__dem__law__a_Dhpp", '#include "dem/search/b.hpp"\n', "dem/law includes dem/search/b.hpp"),
    ("src__dem__contact__a_Dhpp", "\n", "dem/contact is not in the table"),
])
def test_layering_finds_submodules(tree_with, name, text, expected):
    problems, _ = layering.check(tree_with(**{name: text}))
    assert any(expected in problem for problem in problems), problems


def test_layering_passes_submodules_of_the_row(tree_with):
    root = tree_with(src__dem__law__a_Dhpp="\n",
                     src__dem__search__b_Dhpp='#include "dem/law/a.hpp"\n')
    assert layering.check(root)[0] == []


def test_layering_finds_crowded_folders_and_cycles_of_the_table(tree_with):
    crowd = {f"src__core__c{number}_Dhpp": "\n" for number in range(25)}
    assert any("26 files" in problem for problem in layering.check(tree_with(**crowd))[0])
    cyclic = TABLE.replace("| dem/law | |", "| dem/law | search |")
    root = tree_with(docs__architecture_Dmd=cyclic)
    assert any("no row above it" in problem for problem in layering.check(root)[0])


def test_glossary_finds_terms_by_scope(tree_with):
    table = "| `so far\\|until today` | up to now | text code |\n| `way_` | travel | code |\n"
    root = tree_with(docs__glossary_Dmd=table, src__core__c_Dhpp="// the way_ so far\nint way_;\n",
                     tests__a_Dpy='"""So far."""\n')
    problems, terms = glossary.check(root)
    assert terms == 2
    assert [problem.split(": ")[0] for problem in problems] == [
        "src/core/c.hpp:1", "src/core/c.hpp:2", "tests/a.py:1"]


@pytest.mark.parametrize("include, expected", [
    ('"trackbed/dem/a.hpp"', "may include only: ['core']"),
    ('"dem/private.hpp"', "private header of dem"),
    ('"../dem/private.hpp"', "private header of dem"),
    ('"trackbed/nowhere/a.hpp"', "nowhere is not in the table"),
    ("<mpi.h>", "which only ['par'] may"),
    ("<hdf5.h>", "which only [] may"),
])
def test_layering_finds(tree_with, include, expected):
    root = tree_with(src__par__c_Dcpp=f"\n#include {include}\n" if "mpi" not in include else "",
                     src__dem__private_Dhpp=f"#include {include}\n" if "mpi" in include else "")
    problems, _ = layering.check(root)
    assert len(problems) == 1 and expected in problems[0]


def test_layering_finds_arrow_up_and_unlisted_module(tree_with):
    root = tree_with(docs__architecture_Dmd=TABLE.replace("| par | core", "| par | core dem"),
                     src__new__a_Dcpp="#include <vector>\n")
    problems, _ = layering.check(root)
    assert any("par may include dem, which is not above" in problem for problem in problems)
    assert any("module new is not in the table" in problem for problem in problems)


@pytest.mark.parametrize("line, expected", [
    ("// see " + "/" + "work/main", "path of a particular machine"),
    ("cd " + "/" + "root/x", "path of a particular machine"),
    ("// " + 98 * "x", "101 columns"),
    ("int a;  ", "blanks"),
])
def test_words_finds(tree_with, line, expected):
    problems, _ = words.check(tree_with(src__core__c_Dcpp=line + "\n"))
    assert len(problems) == 1 and expected in problems[0]


@pytest.mark.parametrize("word", ["Purpose", "Source", "Ranks", "Run time"])
def test_words_finds_deck_without(tree_with, word):
    problems, _ = words.check(tree_with(inputs__b_Dtoml=HEAD.replace(word, "Other")))
    assert len(problems) == 1 and word.lower() in problems[0]


def test_format_finds(tree_with):
    root = tree_with(src__core__c_Dcpp="int  a ;\n")
    code, report = layout.check(root)
    assert code != 0 and "c.cpp:1" in report


def test_kinds_of_stages_come_from_the_schema():
    schema = ('{"properties": {"stage": {"items": {"properties": '
              '{"kind": {"enum": ["fill", "run"]}}}}}}')
    row = "| stage | a part of a run: {} |\n"
    assert (generated_docs.with_stage_kinds(row.format("fill, walk"), schema)
            == row.format("fill, run"))
    with pytest.raises(SystemExit):
        generated_docs.with_stage_kinds("| stages | none |", schema)


def test_generated_docs_finds(tmp_path):
    (tmp_path / "input.md").write_text("old\n")
    assert generated_docs.differences("input.md", "old\n", tmp_path / "input.md") == []
    found = generated_docs.differences("input.md", "new\n", tmp_path / "input.md")
    assert "-old" in found and "+new" in found
    assert generated_docs.differences("input.md", "new\n", tmp_path / "missing.md")


@pytest.fixture(name="package")
def package_fixture(tmp_path, monkeypatch):
    package = tmp_path / "postproc/trackbed_post"
    package.mkdir(parents=True)
    (tmp_path / "docs").mkdir()
    (package / "__init__.py").write_text('"""Results."""\n__all__ = ["of"]\n')
    (package / "read.py").write_text('def of(x: int, y=1) -> int:\n    """Reads."""\n')
    monkeypatch.setattr(python_document, "NAMES", {"": ()})
    (tmp_path / python_document.DOCUMENT).write_text(python_document.written_from(tmp_path))
    return tmp_path


def test_python_document_finds(package):
    text = (package / python_document.DOCUMENT).read_text()
    assert "of(x: int, y=1) -> int" in text and "Reads." in text
    assert python_document.check(package) == []
    example = package / "docs/a.md"
    example.write_text("```python\nfrom trackbed_post import signals\n```\n")
    assert "trackbed_post.signals" in python_document.check(package)[0]
    example.unlink()
    source = package / "postproc/trackbed_post/read.py"
    source.write_text(source.read_text().replace("y=1", "y=2"))
    assert "out of date" in python_document.check(package)[0]
    source.write_text("def of(x):\n    return x\n")
    with pytest.raises(SystemExit, match="no description of of"):
        python_document.check(package)


def test_troubleshooting_finds(tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "docs").mkdir()
    (tmp_path / "src/a.cpp").write_text('f("a stone left "\n  "the domain at {}");\n')
    document = tmp_path / "docs/troubleshooting.md"
    document.write_text("| `... left the domain at` | cause | remedy |\n"
                        "| `no slots` (mpirun) | cause | remedy |\n")
    assert troubleshooting.check(tmp_path) == ([], 1)
    document.write_text("| x |\n| `... leaves the domain` | cause | remedy |\n")
    assert "troubleshooting.md:2" in troubleshooting.check(tmp_path)[0][0]


def test_verification_page_finds(tmp_path):
    row = "ground\tColumn.FrontArrives/plane\tarrival\ts\t{}\t=\t1.5\t0.1\tan element: 0.1 s\n"
    (tmp_path / "a_test_2.tsv").write_text(row.format("9"))  # of more ranks: ignored
    (tmp_path / "a_test_1.tsv").write_text(row.format("1.52"))
    rows = verification.rows_of(tmp_path)
    page = verification.document_of(rows)
    cells = ["Column: front arrives (plane)", "arrival", "1.52 s", "1.5 s", "0.1 s",
             "an element: 0.1 s"]
    assert "| " + " | ".join(cells) + " |\n" in page
    assert not verification.differences(rows, page)
    (tmp_path / "a_test_1.tsv").write_text(row.format("1.53"))  # another machine's digits
    assert not verification.differences(verification.rows_of(tmp_path), page)
    for changed, said in ((page.replace("1.52 s", "1.7 s"), "measured 1.52"),
                          (page.replace("| 0.1 s", "| 0.2 s"), "the test"),
                          (page.replace("| an element", "| a step"), "the test"),
                          (page.replace("| an element: 0.1 s |", "|"), "not in the document"),
                          (page.replace("| arrival", "| leave"), "not measured"),
                          (page.replace("| arrival", "| leave"), "not in the document")):
        assert any(said in line for line in verification.differences(rows, changed)), said


@pytest.mark.parametrize("cells,said", [
    ("1.5\t0.1\tan element", "two rows"), ("1.5\t0.1\t ", "no reason"),
    ("1.5\t0.1", "no reason"), ("1.5\t0.1\tan element | a step", "a cell contains"),
])
def test_verification_page_refuses(tmp_path, cells, said):
    row = f"ground\tColumn.FrontArrives\tarrival\ts\t1.52\t=\t{cells}\n"
    (tmp_path / "a_test_1.tsv").write_text((2 if said == "two rows" else 1) * row)
    with pytest.raises(SystemExit, match=said):
        verification.rows_of(tmp_path)


def test_verification_page_shows_the_digits_that_a_tolerance_resolves(tmp_path):
    (tmp_path / "a_test_1.tsv").write_text(
        "track\tUplift.Beam\twork\t-\t0.5333333333334\t=\t0.533333333333333\t1e-12\trounding\n")
    page = verification.document_of(verification.rows_of(tmp_path))
    assert "| 0.5333333333334 | 0.5333333333333 | 1e-12 | rounding |" in page


def test_spelling_finds_a_misspelling(tree_with):
    assert spelling.check(tree_with())[0] == []
    problems, _ = spelling.check(tree_with(src__core__c_Dhpp="// the rec" + "ieved load\n"))
    assert any("src/core/c.hpp:1" in problem for problem in problems), problems


def test_typed_finds(tree_with):
    pytest.importorskip("mypy")
    root = tree_with(postproc__trackbed_post__a_Dpy='def f() -> int:\n    return ""\n')
    code, report = typed.check(root)
    assert code != 0 and "trackbed_post/a.py:2: error" in report


@pytest.mark.parametrize("text, expected", [
    ("[a](docs/b.md)\n", ""), ("[a](docs/b.md#two-words)\n", ""), ("[a](https://a.b/c)\n", ""),
    ("```\n[a](docs/c.md)\n```\n", ""), ("[a](docs/c.md)\n", "no such file"),
    ("![a](docs/c.png)\n", "no such file"), ("[a](docs/b.md#three)\n", "no such heading")])
def test_links_are_followed(tree_with, text, expected):
    root = tree_with(README_Dmd=text, docs__b_Dmd="# Two words\n")
    found = list(links.dead_links(root / "README.md"))
    assert bool(found) == bool(expected) and all(expected in line for line in found)


def test_every_document_has_a_chapter(tree_with):
    root = tree_with(jobs__site_Dpy='CHAPTERS = {"a": ("b", "architecture")}\n',
                     docs__b_Dmd="# B\n", docs__c_Dmd="# C\n")
    assert [line.split(":")[0] for line in links.without_chapter(root)] == [
        str(root / "docs/c.md")]


def test_numbers_of_the_readme_are_compared(tmp_path):
    root = pathlib.Path(__file__).resolve().parents[2]
    deck = "inputs/quickstart.toml"
    for name in ("README.md", "docs/images/quickstart.dat", deck):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text((root / name).read_text())
    assert readme.check(tmp_path) == ([], 25)
    text = (tmp_path / "README.md").read_text()
    number = re.search(r"is (0\.\d\d) mm/m", text).group(1)
    (tmp_path / "README.md").write_text(
        text.replace(f"is {number} mm/m", f"is {float(number) + 0.01:.2f} mm/m"))
    assert len(readme.check(tmp_path)[0]) == 1
    (tmp_path / "README.md").write_text(re.sub(r"mean\s+over the bed", "mean", text))
    assert "no sentence" in readme.check(tmp_path)[0][0]
    (tmp_path / "README.md").write_text(text)
    (tmp_path / deck).write_text(
        (root / deck).read_text().replace("load = 100e3", "load = 80e3"))
    assert "12 times with 80 kN" in readme.check(tmp_path)[0][0]


@pytest.mark.parametrize("name, old, new, expected", [
    (recipe.CMAKE[1], "find_package(fmt", "find_package(Boost", ["lacks boost", "fmt is not"]),
    (recipe.CMAKE[1], "Eigen3 3.4", "Eigen3 3.5", ["eigen from 3.4, in CMake from 3.5"]),
    (recipe.RECIPE, 'depends_on("metis@5:")', "", ["lacks metis", "metis is in only one"]),
    (recipe.DEBIAN, "  gmp:", "  gmpxx:", ["gmp is in only one", "gmpxx is in only one"])])
def test_recipe_finds(tmp_path, name, old, new, expected):
    root = pathlib.Path(__file__).resolve().parents[2]
    for copied in (*recipe.CMAKE, recipe.RECIPE, recipe.DEBIAN):
        (tmp_path / copied).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / copied).write_text((root / copied).read_text())
    assert recipe.check(tmp_path) == ([], 15)
    text = (tmp_path / name).read_text()
    assert old in text
    (tmp_path / name).write_text(text.replace(old, new))
    problems, _ = recipe.check(tmp_path)
    assert all(any(part in problem for problem in problems) for part in expected), problems
