"""Figure and table of the receptances of a track under an impact."""
import matplotlib.figure
import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import panels

Receptances = dict[str, np.ndarray]  # by the names of places: complex numbers, m/N


def draw(frequency: np.ndarray, found: Receptances) -> matplotlib.figure.Figure:
    """Magnitude and phase over the frequency, Hz."""
    figure, (size, phase) = plt.subplots(2, 1, figsize=(8, 7), sharex=True, layout="constrained")
    for number, (name, values) in enumerate(found.items()):
        look = panels.curve(number, 1) | {"markevery": (0.01 * number, 0.1)}
        size.loglog(frequency, np.abs(values), lw=0.9, label=f"rail at {name}", **look)
        phase.semilogx(frequency, np.degrees(np.angle(values)), lw=0.9, **look)
    size.set(ylabel="receptance, m/N")
    phase.set(ylabel="phase, degrees", xlabel="frequency, Hz")
    for panel in (size, phase):
        panel.grid(alpha=0.3, which="both")
    size.legend(fontsize=7)
    return figure


def table(frequency: np.ndarray, found: Receptances) -> str:
    """CSV: the real and imaginary part of each."""
    head = ["frequency_Hz", *(f"{part} rail at {name} m/N" for name in found
                              for part in ("real", "imaginary"))]
    columns = [frequency, *(part for values in found.values()
                            for part in (values.real, values.imag))]
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns)]
    return "\n".join([",".join(head), *rows]) + "\n"
