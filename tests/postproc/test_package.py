"""The package is typed, without mypy, which tests/style/typed.py runs."""
import ast
import tomllib

import conftest
import pytest

POSTPROC = conftest.ROOT / "postproc"
SETTINGS = tomllib.loads((POSTPROC / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
TYPED = SETTINGS["mypy"]["overrides"][0]["module"]


def untyped(text):
    """Names of the functions with a parameter or a result that has no annotation."""
    for one in ast.walk(ast.parse(text)):
        if isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef)):
            every = one.args
            given = [*every.posonlyargs, *every.args, *every.kwonlyargs, every.vararg, every.kwarg]
            if not one.returns or any(not each.annotation for each in given
                                      if each and each.arg != "self"):
                yield one.name


@pytest.mark.parametrize("module", TYPED)
def test_functions_are_annotated(module):
    path = POSTPROC / module.replace(".", "/")
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    assert not list(untyped(path.read_text(encoding="utf-8")))


def test_missing_annotations_are_found():
    assert list(untyped("def a(b): pass\ndef c(d) -> int: pass\ndef e(self) -> int: pass\n"
                        "def f() -> None:\n    def g(): pass\n")) == ["a", "c", "g"]


def test_users_see_the_types():
    marker = "py.typed"
    assert (POSTPROC / "trackbed_post" / marker).is_file()
    assert marker in SETTINGS["setuptools"]["package-data"]["trackbed_post"]
    assert marker in (conftest.ROOT / "cmake/Install.cmake").read_text(encoding="utf-8")
