"""The command `trackbed_post ballast`: stiffness of the ballast and a void below a sensor."""
import matplotlib.pyplot as plt

from trackbed_post import measured, panels
from trackbed_post.monitor import ballast, forces

WORDS = {"outside": "stiffness of the ballast, far", "inside": "stiffness at the sensor",
         "length": "length of the transition", "void": "void below the sleeper",
         "dip": "dip of the running surface"}
SHOWN = {"outside": ("MN/m", 1e-6), "inside": ("MN/m", 1e-6), "length": ("m", 1.0),
         "void": ("mm", 1e3), "dip": ("mm", 1e3)}
POOR = 2.0  # misfit


def calibrate(signal_name, folder, deck, program, sensor, speed, without, noise=None):
    """Writes a table and a picture of a passage into a write.Folder."""
    signal = measured.acceleration(signal_name)
    free = [name for name in ballast.NAMES if name not in without]
    track = ballast.Track(program, deck, sensor, speed)
    found, moved = ballast.calibrate(signal.values, signal.rate, track, free, signal.doubtful,
                                     noise)
    folder.remarks += [*signal.remarks, *forces.faults_of(moved)]
    lines = []
    for name in free:
        unit, factor = SHOWN[name]
        lines.append(f"{WORDS[name]:30} {factor * found.value[name]:10.4g} {unit:5} standard "
                     f"deviation {factor * found.deviation[name]:.2g}\n")
    if "void" in free:
        lines.append(f"{'there is a void':30} {'yes' if found.has_void else 'no':>10}\n")
    lines.append(f"{'misfit':30} {found.misfit:10.3g}\n")
    folder.table("ballast.txt", "".join(lines))
    folder.remarks += remarks_of(found)
    folder.picture("ballast", picture(found, track.sensor))


def remarks_of(found):
    """Of a Ballast that the signal hardly supports."""
    remarks, void = [], found.value["void"]
    if void > 0 and not found.has_void:
        remarks.append(f"the void of {1e3 * void:.2g} mm reduces the sum of squares by "
                       f"{found.gain:.2g}, not by more than {ballast.SIGNIFICANT**2:g}: it may be "
                       "none, but the other values are those with it; compare them with those of "
                       "--without void")
    if found.misfit > POOR:
        remarks.append(f"the misfit of {found.misfit:.2g} is above {POOR:g}: the model does not "
                       "explain the signal; its values and deviations mean little")
    return remarks


def picture(found, sensor):
    figure, panel = plt.subplots(figsize=(10, 4), constrained_layout=True)
    panel.plot(found.x, 1e3 * found.measured, ".", ms=3, label="reconstructed")
    panel.plot(found.x, 1e3 * found.model, lw=1, label="model")
    panel.axvline(sensor, color="0.6", lw=0.8, ls=":")
    panel.set_xlabel("position of the first wheel (m); dotted: sensor")
    panel.set_ylabel(f"displacement of the sleeper ({panels.UP})")
    panel.set_title(f"Wavelengths above {ballast.FITTED:g} m: ballast at the sensor "
                    f"{1e-6 * found.value['inside']:.3g} MN/m of one rail seat", fontsize=10)
    panel.legend(fontsize=8)
    panel.grid(alpha=0.3)
    return figure
