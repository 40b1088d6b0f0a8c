"""What the scripts of studies compute themselves: numbers, targets, outlines."""
import pathlib
import sys
import tomllib

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "jobs"))
from studies import netirail, netirail_document  # noqa: E402
from studies.study import Lines, Numbers, Target, targets_table  # noqa: E402


def test_numbers_and_lines_are_read_as_written(tmp_path):
    numbers = Numbers({"version": "trackbed 1, commit abc", "command": "a: b"})
    numbers.put("run", "rail, 41 m", 0.123456789, "mm")
    numbers.put("other", "force", -1e5, "N")
    (tmp_path / "numbers.csv").write_text(numbers.text(), encoding="utf-8")
    found = Numbers.read(tmp_path / "numbers.csv")
    assert found.about == numbers.about
    assert found("run", "rail, 41 m") == 0.123457 and found("other", "force") == -1e5
    assert found.rows == numbers.rows and found.has("run") and not found.has("none")
    lines = Lines()
    lines.put("figure", "one, two", [0.5, 1.25], [3, -4])
    (tmp_path / "lines.csv").write_text(lines.text(), encoding="utf-8")
    assert Lines.read(tmp_path / "lines.csv").of("figure") == {"one, two": ((0.5, 1.25), (3, -4))}


@pytest.mark.parametrize("ours, yes", [(1.0, True), (1.25, True), (1.26, False), (-1.0, False)])
def test_a_target_is_reproduced_within_its_deviation(ours, yes):
    target = Target("rail", "main", "about 1 mm", ours, "mm", 1.0, 0.25)
    assert target.reproduced() == yes
    assert ("| yes |" in targets_table([target])) == yes


@pytest.mark.parametrize("form", ["short", "full"])
def test_each_run_has_a_folder_of_its_own_and_a_deck(form):
    runs = netirail.runs(form, 2)
    assert len({run.name for run in runs}) == len(runs) > 3
    inputs = pathlib.Path(__file__).resolve().parents[2] / "inputs"
    assert all((inputs / run.deck).is_file() for run in runs)


def area(outline):
    x, z = np.transpose(outline)
    return abs(np.dot(x, np.roll(z, 1)) - np.dot(z, np.roll(x, 1))) / 2


def test_strips_of_the_wedge_add_up_to_it():
    for reach in map(netirail.reach_of, netirail.WEDGE):
        parts = [netirail.clip(6 + 3 * k, 9 + 3 * k, reach) for k in range(8)]
        assert sum(area(part) for part in parts if part) == pytest.approx(reach * 8.4 / 2)


def test_mirrored_layers_and_points_are_those_of_the_deck_seen_from_the_other_end():
    words = dict(word.split("=") for word in netirail.mirrored())
    deck = (pathlib.Path(__file__).resolve().parents[2]
            / "inputs/track/netirail_2d.toml").read_text(encoding="utf-8")
    blocks = {block["name"]: np.reshape(block["outline"], (-1, 2))
              for block in tomllib.loads(deck)["ground"]["block"]}
    for name, outline in blocks.items():
        mirror = np.reshape(np.fromstring(words[f"ground.block.{name}.outline"].strip("[]"),
                                          sep=","), (-1, 2))
        assert np.allclose(mirror, outline * [-1, 1] + [60, 0])
    assert np.allclose(np.fromstring(words["passage.points"].strip("[]"), sep=","),
                       [83.4 - 32.4, 83.4 - 58.8])


def test_wide_sleepers_have_the_spring_of_the_deck_formula():
    z = (np.arange(1000) + 0.5) * 0.3e-3  # m, half of the depth spreads on each free side

    def spring(width):
        return 1 / np.sum(0.3e-3 / ((width + z) * (1.3 + z / 2)))
    assert f"bed={spring(0.58) / spring(0.29):.2f}" in netirail.WIDE
    assert f"footprint={(0.58 + 0.3) / (0.29 + 0.3):.2f}" in netirail.WIDE


def test_the_steepest_change_is_that_within_the_window():
    x = np.arange(0, 10, 0.5)
    down = np.where(x < 3, 0, 1) + np.where(x < 8, 0, 5)
    assert netirail.steepest(x, down, (-1, 7)) == 2 and netirail.steepest(x, down, (-1, 11)) == 10


def test_the_document_states_what_the_numbers_say():
    """With the numbers of docs/studies, of which one is changed."""
    folder = pathlib.Path(__file__).resolve().parents[2] / "docs/studies/netirail"
    numbers = Numbers.read(folder / "numbers.csv")
    before = netirail_document.document(numbers)
    one, three = ("plane_same_width_fill_1", "rail, 14.7 m"), ("plane_same_width_fill_3",
                                                              "rail, 14.7 m")
    numbers.rows[three] = (0.5 * numbers.rows[one][0], "mm")
    after = netirail_document.document(numbers)
    words = "largest reduction by mass alone in these experiments is -50.0 %"
    assert words in " ".join(after.split()) and words not in " ".join(before.split())


def test_own_weight_on_a_plane_layer():
    # 157.5 kg on 0.6 x 6.5 m: 396 Pa on 9 m of 80 MPa / (1 - 0.09).
    assert netirail.own_weight(1) == pytest.approx(0.0405, abs=1e-4)
