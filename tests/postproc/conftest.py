"""postproc's modules are scripts in a folder, not an installed package."""
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "postproc"))

import made  # noqa: E402
import read  # noqa: E402


@pytest.fixture(name="runs", scope="module")
def two_runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    return [read.results(made.write(folder / name, wedge=name == "wedge"))
            for name in ("wedge", "no_wedge")]
