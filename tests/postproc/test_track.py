"""Tests of track_figures.py on made-up histories whose numbers are known."""
import matplotlib.pyplot as plt
import numpy as np
import pytest
import read
import track_figures


def made(sleepers=True):
    """Two wheels 10 m apart at 10 m/s, 50 and 60 kN, over a rail point at 5 m of 20 m of track; the
    first one's force doubles after it has left."""
    time = np.linspace(0, 3, 301)
    x = np.stack([10 * time, 10 * time - 10], axis=1)
    force = np.where(x > 20, 2, 1) * [50e3, 60e3]
    dent = -1e-3 * np.exp(-(x - 5)**2).sum(axis=1)
    run = {"history/time": time, "history/wheel/x": x, "history/wheel/force": force,
           "history/rail/displacement": dent, "rail/x": np.array([5.0])}
    if sleepers:
        run |= {"sleepers/x": np.array([4.8]), "history/sleeper/displacement": 0.5 * dent,
                "history/sleeper/acceleration": np.full(301, -2.0),
                "history/sleeper/seat_force": -20e6 * dent}
    return {name: read.Quantity(values, "-", "made for a test") for name, values in run.items()}


def test_wheels_count_on_the_track_alone():
    found = track_figures.numbers(made(), 20)
    assert found["largest wheel force"] == (pytest.approx(60), "kN")
    assert found["least wheel force"] == (pytest.approx(50), "kN")


def test_rail_sleeper_and_seat():
    found = track_figures.numbers(made(), 20)
    assert found["rail at 5 m, down"][0] == pytest.approx(1, rel=1e-3)
    assert found["sleeper at 4.8 m, down"][0] == pytest.approx(0.5, rel=1e-3)
    assert found["seat at 4.8 m, largest load"][0] == pytest.approx(20, rel=1e-3)
    name = next(name for name in found if "acceleration" in name)
    # 100 rows in a second cannot carry 100 Hz: the name says so.
    assert "unfiltered" in name and found[name][0] == pytest.approx(2)


@pytest.mark.parametrize("sleepers, panels", [(True, 4), (False, 2)])
def test_panels(sleepers, panels):
    figure = track_figures.draw(made(sleepers), 20)
    assert len(figure.axes) == panels
    plt.close(figure)


def test_runs_of_a_bed_are_refused(monkeypatch):
    monkeypatch.setattr(read, "datasets", lambda _: {"history/time": None})
    with pytest.raises(SystemExit) as refused:
        track_figures.loaded("somewhere")
    assert refused.value.code == 2
