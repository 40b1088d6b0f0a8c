"""The package of postproc/ without installing it, and its command line."""
import contextlib
import io
import pathlib
import sys
import types

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "postproc"))

import made  # noqa: E402
import trackbed_post.__main__  # noqa: E402
from trackbed_post import read  # noqa: E402


@pytest.fixture(name="runs", scope="module")
def two_runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    return [read.results(made.write(folder / name, wedge=name == "wedge"))
            for name in ("wedge", "no_wedge")]


def call(*words):
    """A command within this process, which saves its start: returncode, stdout, stderr."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = trackbed_post.__main__.main([str(word) for word in words])
        except SystemExit as ending:  # of argparse
            code = ending.code
    return types.SimpleNamespace(returncode=code, stdout=out.getvalue(), stderr=err.getvalue())
