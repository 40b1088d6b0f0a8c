"""Files of figures: their size in formats of lines, and the text at the lower edge."""
import base64
import io
import re
import types

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

from trackbed_post import bed_on_ground, field_sections, maps, model_drawing, write

MANY = 5_000  # more than those of the quickstart
MEGABYTE = 1_000_000


def thousands():
    """(panel, stones, chains)"""
    rng = np.random.default_rng(1)
    centre = rng.random((MANY, 2)) * [19.2, 0.5]
    stones = types.SimpleNamespace(radius=np.full(MANY, 0.02), centre=centre)
    segments = np.hstack([centre, centre + 0.02])
    chains = types.SimpleNamespace(segments=segments, force=rng.exponential(1e3, MANY))
    panel = plt.subplots(figsize=(11, 3))[1]
    panel.set(xlim=(0, 19.2), ylim=(0, 0.6))
    return panel, stones, chains


def draw_bed(panel, stones, chains):
    bed_on_ground.draw_chains(panel, chains, stones, 1e4)


def draw_model(panel, stones, chains):
    scene = model_drawing.Scene.__new__(model_drawing.Scene)
    scene.panel, scene.chains = panel, None
    scene.run = types.SimpleNamespace(stones={"end": stones})
    scene._draw_stones()
    scene.set_chains(model_drawing.Chains(chains.segments.reshape(-1, 2, 2), chains.force), 1e4)


@pytest.mark.parametrize("draw", [draw_bed, draw_model])
def test_thousands_of_stones_are_pixels_of_300_dpi_in_small_files(draw, tmp_path):
    panel, stones, chains = thousands()
    draw(panel, stones, chains)
    write.Folder(tmp_path, formats=("svg", "pdf")).picture("bed", panel.figure)
    svg = (tmp_path / "bed.svg").read_text()
    assert svg.count("<path") < 200 and len(svg) < 2 * MEGABYTE
    assert (tmp_path / "bed.pdf").stat().st_size < 2 * MEGABYTE
    images = [Image.open(io.BytesIO(base64.b64decode(one)))
              for one in re.findall(r"data:image/png;base64,([^\"]+)", svg)]
    assert images and max(one.width for one in images) > 2500  # pixels of about 8.5 inches


def test_the_text_at_the_lower_edge_is_beside_the_colour_bar(tmp_path):
    """Also of a flat field, whose picture is low."""
    x = np.linspace(0, 19.2, 60)
    at = np.stack(np.meshgrid(x, [0.0, -0.5, -1.0]), -1).reshape(-1, 2)
    layer = field_sections.Layer("stones", at, at[:, 0], None)
    figure = maps.draw([layer], "title", field_sections.Choices(), "Pa")
    write.Folder(tmp_path, "a title\ntrackbed 0: run, drawn today").picture("map", figure)
    text = figure.texts[-1].get_window_extent()
    for axes in figure.axes:
        assert axes.get_tightbbox().y0 >= text.y1


@pytest.mark.filterwarnings("error")
def test_arrows_of_no_length_are_drawn():
    at = np.stack([np.arange(20.0), np.zeros(20)], 1)
    values = np.ones((20, 3), np.float32)  # as in field files
    values[3] = 0
    figure = maps.draw([field_sections.Layer("stones", at, values, None)], "",
                       field_sections.Choices(), "N")
    arrows, = (one for one in figure.axes[0].collections if hasattr(one, "U"))
    assert arrows.U == pytest.approx(values[:, 0])
    plt.close(figure)
