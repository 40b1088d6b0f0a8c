"""Shades of the ground's blocks behind curves along the track, the same in all figures."""
import textwrap

import numpy as np

from trackbed_post import ground_blocks

STRUCTURE = {"color": "0.35", "alpha": 0.3}
SOFT = {"color": "tab:green", "alpha": 0.13}
RUN_IN = {"color": "0.5", "alpha": 0.2}  # of a track without a bed
WIDE = 30  # characters of a line of names


def shade(panel, stretches):
    """Shades ground_blocks.stretches() over x."""
    for one in stretches:
        panel.axvspan(one.low, one.high, lw=0, zorder=0, **(STRUCTURE if one.structure else SOFT))


def name(panel, stretches, z=0.97):
    """Writes their names at this height of the panel, 0 to 1, where it shows them."""
    low, high = panel.get_xlim()
    for one in stretches:
        begin, end = np.clip((one.low, one.high), low, high)
        if begin < end:
            panel.text((begin + end) / 2, z, textwrap.fill(one.label, WIDE), fontsize=9,
                       ha="center", va="top" if z > 0.5 else "bottom", clip_on=True,
                       transform=panel.get_xaxis_transform())
