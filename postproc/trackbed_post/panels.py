"""What panels of several figures have in common: the sign of displacements, legends that hide no
curve."""
from matplotlib.axes import Axes

UP = "mm, up positive"  # of all displacements on axes


def legend_above(panel: Axes, columns: int = 4, size: float = 8) -> None:
    """A legend between the panel and what is above it."""
    panel.legend(loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.2, ncols=columns,
                 fontsize=size, frameon=False)


def legend_below(panel: Axes, columns: int = 2, size: float = 8) -> None:
    """A legend below the label of the panel's x axis, for panels with a title."""
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=columns, fontsize=size,
                 frameon=False)
