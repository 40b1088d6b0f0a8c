"""Figures of results made of known functions: what is drawn, and its titles and labels."""
import csv
import dataclasses
import datetime
import io

import conftest
import made
import matplotlib.image
import matplotlib.pyplot as plt
import numpy as np
import pytest
from trackbed_post import (bed_figures, bed_histories, bed_on_ground, bed_warnings,
                           contact_forces, figure_csv, ground_blocks, ground_transition, measures,
                           read, sleeper_histories, stress_paths, support, support_figure, write)


def test_figures_of_two_runs_are_drawn(runs, tmp_path):
    folder = write.Folder(tmp_path)
    bed_on_ground.draw_all(runs, folder)
    paths = folder.pictures
    assert {path.stem for path in paths} == set(bed_on_ground.FIGURES)
    for path in paths:
        picture = matplotlib.image.imread(path)
        assert min(picture.shape[:2]) > 300
        # An empty frame has a few per cent of ink; every one of these has curves on it.
        assert np.mean(np.min(picture[..., :3], axis=2) < 0.95) > 0.005, path.stem
    assert "displacement on the structure" in (tmp_path / "table.txt").read_text()


def test_titles_contain_the_results(runs):
    title = bed_on_ground.envelope(runs).axes[0].get_title()
    assert "wedge: 2." in title or "wedge: 1.9" in title
    spike = runs[0].ground_envelope["sigma_z_min"].values.copy()
    spike[45] -= 70e3  # a single node, 0.1 m from its neighbours: a sixth of it in the mean
    run = dataclasses.replace(runs[0], ground_envelope={
        **runs[0].ground_envelope, "sigma_z_min": read.Quantity(spike, "Pa", "")})
    title = bed_on_ground.stress([run]).axes[0].get_title()
    assert title.endswith("\nlargest mean over one sleeper spacing: wedge 100 kPa")
    assert "without weight of the bed and static" in bed_on_ground.stress(runs).axes[0].get_title()
    assert bed_on_ground.FILTER.name in sleeper_histories.draw(runs).axes[3].get_ylabel()
    assert "thickest line 0.9 kN" in bed_on_ground.force_chains(runs).axes[0].get_title()
    bed_on_ground.plt.close("all")


def test_the_largest_mean_stress_is_not_below_that_of_the_table(runs):
    """Near the structure's edge the stress is largest, up to the node of the edge, which the means
    of the table leave out."""
    for run, edge in zip(runs, map(ground_blocks.edge_of_structure, runs)):
        x = run.ground_x
        peaked = dataclasses.replace(run, ground_envelope={
            **run.ground_envelope, "sigma_z_min": read.Quantity(
                np.where((x < edge - 1e-6) & (x > edge - 0.61), -200e3, 0.0), "Pa", "")})
        title = bed_on_ground.stress([peaked]).axes[0].get_title()
        in_table = ground_transition.transition(peaked).stress_structure
        assert title.endswith(f" {run.name} {in_table / 1e3:.0f} kPa")
    bed_on_ground.plt.close("all")


def with_passage_chains(run, load):
    """The run with force chains also at the end of the passage, and `load` N on seats at load."""
    seat = run.sleeper["seat_force"].values.copy()
    seat[run.stage == 3] = -load
    seat[-1] = -5e3
    return dataclasses.replace(
        run, chains={**run.chains, "passage": run.chains["load"]},
        sleeper={**run.sleeper, "seat_force": read.Quantity(seat, "N", "-")})


@pytest.mark.parametrize("load, stage", [(71e3, "load"), (5e3, "passage"), (0.0, "passage")])
def test_overview_shows_the_stage_under_load_and_names_it(runs, load, stage):
    run = with_passage_chains(runs[0], load)
    assert contact_forces.under_load(run) == stage
    words = f"end of stage {stage}, largest seat load {max(load, 5e3) / 1e3:.1f} kN" + (
        ", after the passage" if stage == "passage" else "")
    for draw in (bed_on_ground.overview, bed_figures.forces):
        title = draw([run]).axes[0].get_title().replace("\n", " ")
        assert words in title, title
    assert contact_forces.under_load(runs[0]) == "load"  # the only stage with force chains
    bed_on_ground.plt.close("all")


def test_the_potential_energy_counts_from_the_begin_of_each_stage(runs):
    """Also of a variant that started at a later stage; where stones are removed between two stages,
    the step is stated and does not hide the rest."""
    values = runs[0].energy["potential"].values - 21e3 * (runs[0].stage == 4)
    first = dataclasses.replace(runs[0], energy={
        **runs[0].energy, "potential": read.Quantity(values, "J", "-")})
    later = slice(100, None)
    variant = dataclasses.replace(
        runs[1], time=runs[1].time[later], stage=runs[1].stage[later],
        energy={name: dataclasses.replace(item, values=item.values[later])
                for name, item in runs[1].energy.items()})
    axes = bed_histories.energy([first, variant]).axes
    kinetic = " and ".join(f"{run.name} {run.energy['kinetic'].values[-1]:.3g} J at "
                           f"{run.time[-1]:.3f} s" for run in (first, variant))
    assert " ".join(axes[0].get_title().split()).replace("; ", " and ") == (
        f"Energies of the stones kinetic energy in the last row of the histories: {kinetic}")
    assert [axis.get_ylabel().split(",")[0] for axis in axes] == ["kinetic (J)", "elastic",
                                                                  "potential"]
    drawn = [line.get_ydata() for line in axes[2].lines[:2]]
    expected = 100 * (np.sin(first.time[-1]) - np.sin(first.time[100]))
    assert drawn[0][-1] == pytest.approx(expected) and drawn[1][-1] == pytest.approx(expected)
    assert np.nanmax(np.abs(drawn[0])) < 110 and np.isnan(drawn[0][100]) and drawn[0][101] == 0
    assert axes[2].get_title() == \
        "steps between stages, not shown (for example when stones are removed): " \
        "wedge, begin of passage: -21 kJ"
    assert bed_histories.energy([variant]).axes[2].get_title() == ""
    bed_on_ground.plt.close("all")


def test_energy_is_split_since_the_last_stage_began(runs):
    split = measures.energy_split(runs[0])
    rows = runs[0].stage == 4
    past = np.ptp(runs[0].time[rows])
    stored = 102.001 * np.diff(np.sin(runs[0].time[rows][[0, -1]]))[0]
    assert split.dissipated["friction"][-1] == pytest.approx(5 * past)
    assert split.dissipated["breakage"][-1] == pytest.approx(0.5 * past)
    assert split.missing[0] == 0
    assert split.missing[-1] == pytest.approx((9 - 8.5) * past - stored)
    axes = bed_on_ground.FIGURES["energy_split"](runs).axes
    assert len(axes) == 2 and f"supplied {9 * past:.3g}" in axes[0].get_title()
    labels = axes[0].get_legend_handles_labels()[1]
    assert labels == ["friction", "dashpots", "local damping", "breakage", "supplied less stored"]
    bed_on_ground.plt.close("all")


def test_cells_of_a_region_are_weighted_by_their_stones_and_contacts(runs):
    run = runs[0]
    assert run.regions["slab"]["stress"].values.shape == (len(run.time), 2, 6)
    numbers = dict(zip((label for label, _ in measures.REGION_ROWS),
                       measures.region_numbers(run.regions["slab"], -1)))
    assert numbers["void ratio"] == pytest.approx(0.45 / 0.55)
    assert numbers["bulk density"] == pytest.approx(1400)
    assert numbers["coordination number"] == pytest.approx((30 * 6 + 10 * 4) / 40)
    assert numbers["mean contact force"] == pytest.approx((90 * 100 + 20 * 45) / 110)
    assert numbers["compression zz"] == pytest.approx(8)
    assert numbers["fabric zz"] == pytest.approx((90 * 0.4 + 20 * 0.6) / 110)
    text = measures.region_table(run)
    assert "slab" in text and "void ratio" in text and "0.8182" in text
    lines = bed_on_ground.bed_figures.regions(runs[:1]).axes[2].lines
    assert lines[0].get_ydata()[0] == pytest.approx(8)
    bed_on_ground.plt.close("all")


def test_invariants_and_direction_of_a_stress():
    # Compression 30 along (sin 20, 0, cos 20), 10 across it and along y.
    angle = np.radians(20)
    n = np.array([np.sin(angle), 0, np.cos(angle)])
    tensor = -(10 * np.eye(3) + 20 * np.outer(n, n))
    row = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    assert measures.invariants(row) == pytest.approx((50 / 3, 20))
    assert measures.invariants(row, plane=True) == pytest.approx((20, 10))
    assert np.degrees(measures.principal_direction(row)) == pytest.approx(20)


def with_support(run, lowered, reaction):
    sleeper = {**run.sleeper, "displacement": read.Quantity(-lowered, "m", "-"),
               "reaction": read.Quantity(reaction, "N", "-")}
    return dataclasses.replace(run, sleeper=sleeper)


def half_wave(run):
    """Half a sine of 2 mm in the first 2 s of the passage, m downwards, [time, sleeper]."""
    time = run.time - run.time[run.passage()][0]
    way = 2e-3 * np.sin(np.pi * np.clip(time, 0, None) / 2)[:, None]
    return way * np.ones((1, len(run.sleepers_x)))


def test_support_of_sleepers(runs):
    run = runs[0]
    way = half_wave(run)
    # 30 kN/mm from the first row on, above a weight of 3 % of the largest reaction.
    reaction = 2e3 + 30e6 * way
    reaction[:, 3] = 40e6 * np.maximum(way[:, 3] - 0.5e-3, 0)   # hangs by 0.5 mm
    found = support.of(with_support(run, way, reaction))
    assert found.bed[0] == pytest.approx(30e6) and found.whole[0] == pytest.approx(30e6)
    assert found.gap[0] == pytest.approx(0, abs=1e-12)
    assert found.gap[3] == pytest.approx(0.5e-3, abs=1e-9)
    assert found.bed[3] == pytest.approx(40e6)
    assert found.hanging == 1
    assert found.whole[3] == pytest.approx(40e6 * 1.5 / 2)      # the gap included
    assert list(np.flatnonzero(found.hangs)) == [3]
    loops, stiff, gaps = support_figure.draw([with_support(run, way, reaction)]).axes
    assert "1 of" in gaps.get_title()
    assert stiff.lines[0].get_ydata()[0] == pytest.approx(30)
    assert loops.lines[0].get_ydata().max() == pytest.approx(62, rel=1e-5)
    for panel, height in ((stiff, 40), (gaps, 0.5)):
        ring = next(line for line in panel.lines if line.get_markersize() == 9)
        assert ring.get_xdata() == pytest.approx(run.sleepers_x[[3]])
        assert ring.get_ydata() == pytest.approx([height])
    assert "hangs: gap above 0.1 mm" in [text.get_text() for text in stiff.get_legend().texts]
    bed_on_ground.plt.close("all")


def test_a_dip_of_the_reaction_between_two_axles_does_not_matter(runs):
    """Between the axles of a bogie a sleeper is unloaded while the ground stays low: a secant that
    began there, with the ground, would be ten times as stiff."""
    run = runs[0]
    time = run.time - run.time[run.passage()][0]
    press = np.interp(time, [0.2, 0.6, 1.0, 1.4, 1.8], [0, 0.95, 0.1, 1, 0])
    sunk = 2e-3 * np.interp(time, [0.2, 0.6, 1.4, 1.8], [0, 1, 1, 0])
    count, nodes = len(run.sleepers_x), len(run.ground_x)
    way = np.repeat((sunk + 0.3e-3 * press)[:, None], count, axis=1)
    run = with_support(run, way, np.repeat((2e3 + 30e3 * press)[:, None], count, axis=1))
    run = dataclasses.replace(run, ground={"displacement": read.Quantity(
        np.repeat(-sunk[:, None], nodes, axis=1), "m", "-")})
    found = support.of(run)
    assert found.whole == pytest.approx(30e3 / 2.3e-3, rel=1e-3)
    assert found.bed == pytest.approx(100e6, rel=1e-3) and found.hanging == 0


@pytest.mark.parametrize("part, known", [(0.7, True), (0.6, False)])
def test_a_loop_that_is_too_wide_has_no_stiffness(runs, part, known):
    """Sleeper 4 has its largest reaction when it is down by this part of the most."""
    run = runs[0]
    time = run.time - run.time[run.passage()][0]
    press = np.interp(time, [0.2, 0.6, 1.0], [0, 1, 0])
    way = np.repeat(0.3e-3 * press[:, None], len(run.sleepers_x), axis=1)
    way[:, 4] = 0.3e-3 * np.interp(time, [0.2, 0.6, 1.0, 1.4], [0, part, 1, 0])
    run = dataclasses.replace(with_support(run, way, np.repeat(
        (2e3 + 30e3 * press)[:, None], len(run.sleepers_x), axis=1)), ground={})
    found = support.of(run)
    assert np.isfinite(np.delete(found.bed, 4)).all() and np.isfinite(found.bed[4]) == known
    assert list(np.flatnonzero(found.unclear)) == ([] if known else [4])
    assert found.whole[4] == pytest.approx(30e3 / (part * 0.3e-3), rel=1e-2)
    title = support_figure.draw([run]).axes[1].get_title()
    assert title.endswith("2/3 of its maximum: 1") != known
    bed_on_ground.plt.close("all")


def test_bed_and_ground_are_springs_in_series(runs):
    """Stones that become softer under load, on a ground: both stiffnesses are of one increase of
    the reaction, so that their compliances differ by that of the ground."""
    run = runs[0]
    press = half_wave(run) / 2e-3
    way = 0.4e-3 * press**2 + 0.1e-3 * press    # of the stones; softer from load to load
    sunk = 0.02e-3 * press[:, :1]
    run = dataclasses.replace(with_support(run, way + sunk, 2e3 + 30e3 * press), ground={
        "displacement": read.Quantity(np.repeat(-sunk, len(run.ground_x), axis=1), "m", "-")})
    found = support.of(run)
    assert found.bed == pytest.approx(30e3 / 0.5e-3) and (found.whole < found.bed).all()
    assert 1 / found.whole == pytest.approx(1 / found.bed + 0.02e-3 / 30e3)


def test_support_is_relative_to_the_ground(runs):
    """A sleeper that sinks with the ground before its own load comes does not hang."""
    run = runs[0]
    time = run.time - run.time[run.passage()][0]
    press = np.sin(np.pi * np.clip(time - 1, 0, 1))     # its load, in the second second
    sunk = 1e-3 * np.clip(time, 0, 1)                   # the ground, in the first
    count, nodes = len(run.sleepers_x), len(run.ground_x)
    way = np.repeat((sunk + 1e-3 * press)[:, None], count, axis=1)
    run = with_support(run, way, np.repeat((2e3 + 30e3 * press)[:, None], count, axis=1))
    run = dataclasses.replace(run, ground={"displacement": read.Quantity(
        np.repeat(-sunk[:, None], nodes, axis=1), "m", "-")})
    found = support.of(run)
    assert found.bed == pytest.approx(30e6) and found.gap == pytest.approx(0, abs=1e-9)
    assert found.hanging == 0
    assert "0 of" in support.summary(run)
    rows = list(csv.DictReader(support.table([run]).splitlines()))
    assert len(rows) == count and float(rows[0]["bed_N_m"]) == pytest.approx(30e6)
    assert {row["hangs"] for row in rows} == {"0"}
    bare = dataclasses.replace(run, ground={})
    assert support.of(bare).gap.min() > 0.9e-3   # on a rigid floor
    unknown = dataclasses.replace(bare, deck={**run.deck, "ground": {"present": True}})
    assert np.isnan(support.of(unknown).gap).all() and np.isnan(support.of(unknown).bed).all()
    assert "not known" in support.summary(unknown)
    rows = list(csv.DictReader(support.table([unknown]).splitlines()))
    assert {(row["gap_m"], row["hangs"]) for row in rows} == {("nan", "")}


def test_hanging_sleepers_and_a_loose_bed_are_warned_of(runs):
    run = runs[0]
    way = half_wave(run)
    reaction = 2e3 + 30e6 * way
    sound = with_support(run, way, reaction.copy())
    assert not bed_warnings.of(sound)
    reaction[:, 3] = 40e6 * np.maximum(way[:, 3] - 0.5e-3, 0)
    one, = bed_warnings.of(with_support(run, way, reaction))
    assert f"1 of {len(run.sleepers_x)} sleepers hang" in one
    assert f"x = {run.sleepers_x[3]:.2f} m" in one
    stages = [dict(stage) for stage in run.deck["stage"]]
    number = int(run.stage[run.passage()][0])
    stages[number - 1].update(kind="load", settlement=0.2e-3)
    loose = dataclasses.replace(sound, deck={**run.deck, "stage": stages})
    assert not bed_warnings.of(loose)
    way[:, 2] += 0.3e-3 * np.clip(run.time - run.time[run.passage()][0], 0, 1)
    one, = bed_warnings.of(with_support(loose, way, 2e3 + 30e6 * way))
    assert one.startswith("1 of 13 sleepers settle into the bed by more than 0.1 mm in the "
                          "passage, most by 0.3 mm at x = 1.50 m: ")
    stages[number - 1].update(load=10e3, settlement=0)
    _, one = bed_warnings.of(with_support(loose, way, 2e3 + 30e6 * way))
    assert "carry up to 71 kN" in one
    assert "more than the 10 kN with which stage load bedded it in" in one


def test_a_sleeper_that_never_touches_the_stones_hangs(runs):
    run = runs[0]
    time = run.time - run.time[run.passage()][0]
    sunk = 1e-3 * np.sin(np.pi * np.clip(time, 0, 1))
    way = np.repeat(sunk[:, None], len(run.sleepers_x), axis=1)
    run = dataclasses.replace(with_support(run, way, 0 * way), ground={})
    found = support.of(run)
    assert found.gap == pytest.approx(1e-3, rel=1e-3) and found.hanging == len(run.sleepers_x)
    assert np.isnan(found.bed).all()


def test_a_sleeper_that_rises_while_it_is_loaded_has_no_known_gap(runs):
    run = runs[0]
    time = np.clip(run.time - run.time[run.passage()][0], 0, None)
    way = np.repeat(1e-3 * np.cos(time)[:, None], len(run.sleepers_x), axis=1)  # lowest at first
    way -= way[0]
    reaction = 2e3 + 1e3 * np.repeat(time[:, None], len(run.sleepers_x), axis=1)
    reaction[:, 0] = 2e3
    found = support.of(dataclasses.replace(with_support(run, way + 5e-3, reaction), ground={}))
    assert np.isnan(found.gap[1:]).all() and not found.hangs[1:].any()
    assert np.isfinite(found.gap[0])  # not loaded
    assert found.words() == "0 of 15 have a gap above 0.1 mm, of 14 it is not known"


def test_directions_that_turn_over_are_not_joined():
    shown = stress_paths.unbroken(np.array([80.0, 88.0, -88.0, -80.0]))
    assert np.isnan(shown[2]) and np.isfinite(shown[[0, 1, 3]]).all()


def test_paths_in_the_ground_are_those_of_the_total_stress(runs):
    """A shear stress of up to 10 kPa on compressions of 15 and 35 kPa by the weight of the ground:
    by Mohr's circle the direction turns by half the angle whose tangent is 10/((35 - 15)/2)."""
    shear = 10e3 * np.sin(runs[0].time)[:, None]
    soil = {name: read.Quantity(np.array([components]) * factor, "Pa", "made")
            for name, factor, components in (
                ("stress", shear, [0, 0, 0, 0, -1, 0]),
                ("stress_static", np.ones_like(shear), [-15e3, -20e3, -35e3, 0, 0, 0]))}
    run = dataclasses.replace(runs[0], sensors={"soil": soil}, regions={})
    path, turn = stress_paths.draw([run]).axes
    rows = run.passage()
    p, q = path.lines[0].get_data()
    assert p == pytest.approx(np.full(len(p), (15 + 20 + 35) / 3))
    second = ((15 - 20)**2 + (20 - 35)**2 + (15 - 35)**2) / 6 + 1e-6 * shear[rows, 0]**2
    assert q == pytest.approx(np.sqrt(3 * second))
    assert turn.lines[0].get_ydata() == pytest.approx(
        np.degrees(np.arctan2(1e-3 * shear[rows, 0], 10) / 2))
    assert turn.lines[0].get_label() == f"{run.name}: soil (ground)"
    without = dataclasses.replace(run, sensors={"soil": {"stress": soil["stress"]}})
    with pytest.raises(bed_figures.Missing, match="neither regions nor sensors in the ground"):
        stress_paths.draw([without])


def test_sensors_show_the_vertical_motion_in_the_passage(runs):
    motion, velocity, acceleration = bed_on_ground.bed_histories.sensors(runs[:1]).axes
    time, shown = motion.lines[0].get_data()
    assert shown == pytest.approx(-2 * time)   # mm, from zero
    assert velocity.lines[0].get_ydata() == pytest.approx(
        -20 * runs[0].time[runs[0].passage()])  # mm/s
    # A ramp is not changed by the filter, except near its ends.
    middle = slice(200, -200)
    assert acceleration.lines[0].get_ydata()[middle] == pytest.approx(
        -2 * runs[0].time[runs[0].passage()][middle], rel=1e-3)
    bed_on_ground.plt.close("all")


@pytest.mark.parametrize("files, commit", [
    ({"HEAD": "0123456789abcdef\n"}, "01234567"), ({}, ""), ({"HEAD": "ref: refs/heads/a\n"}, ""),
    ({"HEAD": "ref: refs/heads/a\n", "refs/heads/a": "89abcdef01234567\n"}, "89abcdef"),
    ({"HEAD": "ref: refs/heads/a\n", "packed-refs":
      "# pack-refs\n00aabbccddee refs/heads/b\n11aabbccddee refs/heads/a\n"}, "11aabbcc")])
def test_pictures_state_the_commit_that_drew_them(files, commit, tmp_path, monkeypatch):
    for name, text in files.items():
        (tmp_path / ".git" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / ".git" / name).write_text(text, encoding="utf-8")
    assert write.commit_of(tmp_path) == commit
    monkeypatch.setattr(write, "drawn_by", lambda: f"commit {commit}" if commit else "")
    words = write.drawn_words("trackbed 0.1.0, commit abc")
    assert words.endswith(f" by commit {commit}") == bool(commit)
    assert " by " not in write.drawn_words(f"trackbed 0.1.0, commit {commit}")


def test_grading_is_by_mass(runs):
    found = measures.passing(made.SIEVED, [0.02, 0.03, 0.035, 0.05])
    assert found == pytest.approx([0, 25, 25, 100])
    axes = bed_on_ground.bed_figures.grading(runs[:1]).axes[0]
    built, asked = axes.lines
    assert built.get_ydata() == pytest.approx([25, 100])
    assert asked.get_ydata() == pytest.approx([0, 20, 100])
    assert axes.get_title() == "Sieve curves of the stones by mass"
    bed_on_ground.plt.close("all")


def test_breakage_index_of_a_worked_case():
    """0.19057 by hand, with the trapezoidal rule on the sieves up to d95 = 53 mm."""
    openings = 1e-3 * np.array([2.36, 4.75, 9.5, 13.2, 19, 26.5, 37.5, 53, 63])
    before = np.array([0, 0, 0, 0, 2, 10, 45, 95, 100])
    after = np.array([0, 0, 1, 2, 5, 15, 52, 96.5, 100])
    assert measures.breakage_index(openings, before, after) == pytest.approx(0.19057, abs=5e-6)
    assert measures.breakage_index(openings, before, before) == 0


def test_breakage_counts_fragments_and_fines(runs):
    rows = np.zeros((3, len(read.BREAK)))
    rows[:, read.BREAK["time"]] = [2, 1, 3]
    rows[:, read.BREAK["fragment"]] = [7, 8, -1]
    rows[:, read.BREAK["diameter"]] = [0.012, 0.01, 0.004]
    rows[:, read.BREAK["mass"]] = [0.002, 0.001, 0.5]
    first = read.Stones(np.zeros((2, 2)), np.ones(2), np.array([[0.03, 2.0], [0.04, 2.0]]))
    last = read.Stones(np.zeros((2, 2)), np.ones(2), np.array([[0.03, 1.5], [0.04, 2.0]]))
    run = dataclasses.replace(runs[0], stones={"rest": first, "load": last},
                              breaks={"rest": rows[:0], "load": rows})
    assert measures.stages_of_breakage(run) == ("rest", "load")
    assert measures.sieved_with_fines(run, "load")[:, 1].sum() == 4.0
    counts, places, sieves = bed_on_ground.bed_figures.breakage([run]).axes
    assert [list(line.get_ydata()) for line in counts.lines] == [[1, 2, 2], [0, 0, 1]]
    assert "BBI" in sieves.get_legend().get_texts()[1].get_text()
    with pytest.raises(bed_on_ground.Missing):
        bed_on_ground.bed_figures.breakage([dataclasses.replace(run, breaks={})])
    bed_on_ground.plt.close("all")


def test_bonds_are_counted_over_time(runs):
    panels = bed_on_ground.bed_figures.bonds(runs[:1]).axes
    assert list(panels[0].lines[0].get_ydata()) == [3, 2, 2]
    assert [text.get_text() for text in panels[1].get_legend().get_texts()] == ["2 whole",
                                                                               "1 broken"]
    for bonds in ({}, {"load": read.Bonds(np.zeros((0, 9)), np.zeros((0, 11)))}):
        with pytest.raises(bed_on_ground.Missing):
            bed_on_ground.bed_figures.bonds([dataclasses.replace(runs[0], bonds=bonds)])
    bed_on_ground.plt.close("all")


def test_breaks_are_counted_by_sleeper(runs):
    rows = np.zeros((4, len(read.BREAK)))
    rows[:, read.BREAK["x"]] = [0.25, 0.43, 0.65, 0.95]  # sleepers at 0.3 and 0.9 m
    run = dataclasses.replace(runs[0], breaks={"load": rows}, deck=runs[0].deck | {
        "sleepers": {"first": 0.3, "spacing": 0.6, "count": 2, "width": 0.29}})
    near, below, edges = measures.breaks_by_sleeper(run, "load")
    assert (list(near), list(below), list(edges)) == ([2, 2], [2, 1], [1, 0])


def test_sieves_without_prescription_have_plain_numbers(runs):
    axes = bed_on_ground.bed_figures.grading([dataclasses.replace(
        runs[0], grading=np.empty((0, 4)))]).axes[0]
    axes.figure.canvas.draw()
    assert axes.get_title().endswith("\nno curve is prescribed for stones of another run or of "
                                     "several layers")
    assert {"30", "40"} <= {tick.get_text() for tick in axes.get_xticklabels()}
    bed_on_ground.plt.close("all")


def test_section_is_across_the_track(runs):
    axes = bed_on_ground.bed_figures.section(runs[:1]).axes[0]
    mean = axes.lines[0]
    assert mean.get_xdata() == pytest.approx([-1, 0])  # no stones at y = 1
    assert mean.get_ydata() == pytest.approx([0.2, 0.5])
    assert axes.get_title().startswith("Top of the stones across the track; mean, lowest and")
    assert "across" in axes.get_xlabel() and mean.get_label().endswith("mean along the track")
    plane = np.array(runs[0].surface["load"])[:2]
    plane = dataclasses.replace(runs[0], surface={"load": plane})
    axes = bed_on_ground.bed_figures.section([plane]).axes[0]
    assert axes.lines[0].get_label() == "wedge, end of load" and "along" in axes.get_xlabel()
    assert axes.get_title() == "Top of the stones along the track"
    bed_on_ground.plt.close("all")


def test_outline_slopes_down_beside_the_crest(runs):
    deck = {"bed": {"crest": [-0.5, 0.5], "slope": 2.0}, "stage": [{"profile": 0.4}, {}]}
    run = dataclasses.replace(runs[0], deck=deck)
    asked = bed_on_ground.bed_figures.outline(run, np.array([-0.7, 0.0, 0.9]))
    assert asked == pytest.approx([0.3, 0.4, 0.2])
    deck["bed"]["height"] = 0.35  # compacted to less than the cut
    y = np.array([-0.7, 0.0, 0.9])
    assert bed_on_ground.bed_figures.outline(run, y) == pytest.approx([0.3, 0.35, 0.2])
    deck["stage"].append({"kind": "cribs", "profile": 0.4})
    assert bed_on_ground.bed_figures.outline(run, y) == pytest.approx([0.3, 0.4, 0.2])
    assert bed_on_ground.bed_figures.outline(
        dataclasses.replace(run, deck={"bed": {}, "stage": [{}]}), np.zeros(2)) is None


def test_force_distribution_is_a_density():
    force = np.random.default_rng(1).exponential(20.0, 200000)
    share, density = measures.force_distribution(force)
    assert np.sum(density) * (share[1] - share[0]) == pytest.approx(1, abs=2e-3)
    few = density > 0.01
    assert density[few] == pytest.approx(np.exp(-share[few]), rel=0.08)


def test_structure_and_wedge_have_different_shades(runs):
    shades = {patch.get_facecolor() for patch in bed_on_ground.stress(runs).axes[0].patches}
    assert len(shades) == 2
    bed_on_ground.plt.close("all")


def test_thickness_of_chains_is_proportional_to_their_force(runs):
    lines = bed_on_ground.force_chains(runs[:1]).axes[0].collections[-1]
    assert lines.get_linewidths() == pytest.approx(np.array([1, 9]) / 9 * bed_on_ground.CHAIN_WIDTH)
    bed_on_ground.plt.close("all")


def test_a_run_without_ground_draws_the_other_figures(tmp_path):
    folder = write.Folder(tmp_path)
    bed_on_ground.draw_all([read.results(made.write(tmp_path / "bed", ground=False))], folder)
    assert {path.stem for path in folder.pictures} == {
        "sleepers", "spectrum", "third_octaves", "energy", "force_chains", "regions", "forces",
        "grading", "section", "breakage", "bonds", "sensors", "stress_paths", "support",
        "energy_split", "stages"}
    assert any(one.endswith("bed has no ground") for one in folder.remarks)


def test_command_line(tmp_path):
    made.write(tmp_path / "one")
    ran = conftest.call("figures", tmp_path / "one", "-o", tmp_path / "out",
                        "--format", "png,pdf,csv")
    assert ran.returncode == 0, ran.stderr
    assert "stress.png" in ran.stdout and "stress jump" in ran.stdout
    assert (tmp_path / "out/stress.pdf").read_bytes().startswith(b"%PDF")
    with (tmp_path / "out/energy_lines.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    kinetic = [float(row["y"]) for row in rows
               if row["y axis"] == "kinetic (J)" and row["line"] == "one"]
    drawn = read.results(tmp_path / "one").energy["kinetic"].values
    assert kinetic == pytest.approx(drawn, rel=1e-8)
    assert {row["x axis"] for row in rows} == {"simulated time (s)"}
    for words, expected in (((tmp_path, "-o", tmp_path), "was the run completed?"),
                            ((tmp_path / "one", "-o", tmp_path, "--format", "bmp"),
                             "the formats are png, pdf, svg, csv")):
        failed = conftest.call("figures", *words)
        assert failed.returncode == 2 and expected in failed.stderr, failed.stderr


def test_pictures_name_program_run_and_day(runs, tmp_path):
    folder = write.Folder(tmp_path, "trackbed 0: wedge")
    figure = bed_histories.energy(runs)
    folder.picture("energy", figure)
    assert [text.get_text() for text in figure.texts][-1] == "trackbed 0: wedge"
    made.write(tmp_path / "one")
    today = datetime.date.today().isoformat()
    assert write.origin_of([tmp_path / "one"]).partition(" by ")[0].endswith(
        f"one, drawn on {today}")


def rows_of_csv(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_every_figure_has_its_csv(tmp_path):
    """Contact forces have their values, areas both edges, places of breaks their points."""
    run = made.write(tmp_path / "one")
    ran = conftest.call("figures", run, "-o", tmp_path / "out", "--format", "png,csv")
    assert ran.returncode == 0, ran.stderr
    pictures = sorted(path.stem for path in (tmp_path / "out").glob("*.png"))
    assert pictures == sorted(path.stem.removesuffix("_lines")
                              for path in (tmp_path / "out").glob("*_lines.csv"))
    chains = rows_of_csv(tmp_path / "out/force_chains_lines.csv")
    assert [(row["line"], row["x"], row["y"], row["value"], row["quantity"]) for row in
            chains[:4]] == [("contact force 1", "1", "0.1", "100", "contact force, N"),
                            ("contact force 1", "1.1", "0.2", "100", "contact force, N"),
                            ("contact force 2", "3", "0.1", "900", "contact force, N"),
                            ("contact force 2", "3", "0.3", "900", "contact force, N")]
    assert {row["x axis"] for row in chains} == {"x along the track (m)"}
    split = rows_of_csv(tmp_path / "out/energy_split_lines.csv")
    edges = [[float(row["y"]) for row in split if row["line"] == f"friction, {edge} edge"]
             for edge in ("lower", "upper")]
    time = [float(row["x"]) for row in split if row["line"] == "friction, lower edge"]
    assert len(time) == 2000 and np.allclose(edges[0], 0)
    assert np.allclose(edges[1], 5 * np.array(time))  # made with 5 W
    places = [row for row in rows_of_csv(tmp_path / "out/breakage_lines.csv")
              if row["y axis"] == "z (m)"]
    assert [(row["x"], row["y"]) for row in places] == [("0.4", "0.3"), ("0.5", "0.3")]


def test_arrows_and_their_magnitude_are_in_the_csv():
    figure, panel = plt.subplots()
    arrows = panel.quiver([0.0, 1.0], [2.0, 2.0], [1.0, 0.0], [0.0, 1.0])
    figure_csv.state(arrows, "magnitude, mm/s", np.array([5.0, 7.0]))
    panel.fill_between([0, 1], [0, 0], [1, 3])
    panel.scatter([4], [4])  # without a name: background
    rows = list(csv.reader(io.StringIO(figure_csv.of_figure(figure))))[1:]
    plt.close(figure)
    assert [row[3:] for row in rows] == [
        ["magnitude", "0", "2", "5", "magnitude, mm/s"],
        ["magnitude", "1", "2", "7", "magnitude, mm/s"],
        ["band 2, lower edge", "0", "0", "", ""], ["band 2, lower edge", "1", "0", "", ""],
        ["band 2, upper edge", "0", "1", "", ""], ["band 2, upper edge", "1", "3", "", ""]]
