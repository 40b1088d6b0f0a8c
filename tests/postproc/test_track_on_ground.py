"""Tests of the figures of a track on a ground: kinds, parts that count, unfinished passages."""
import conftest
import pytest
import track_on_ground


@pytest.mark.parametrize("kind", ["transition", "train", "bed"])
@pytest.mark.parametrize("points", [(8.0, 12.0), tuple(range(5, 22))])
def test_kinds_of_a_bed_are_refused_in_one_sentence(tmp_path, kind, points):
    """Sleepers with histories are those nearest to the points, and no bed."""
    run = track_on_ground.folder(tmp_path / "w", points=points)
    ran = conftest.call("figures", run, "--kind", kind, "-o", tmp_path / "out")
    assert ran.returncode == 2
    assert ran.stderr.strip() == (
        f"w: figures of kind {kind} need a bed of stones; this run (model = \"track_on_ground\") "
        "has figures of kind track")
    assert not (tmp_path / "out").exists()


def test_two_tracks_have_no_film_of_a_transition(tmp_path):
    runs = [track_on_ground.folder(tmp_path / name) for name in "wn"]
    ran = conftest.call("film", *runs, "-o", tmp_path / "film.gif")
    assert ran.returncode == 2 and "need a bed of stones" in ran.stderr
