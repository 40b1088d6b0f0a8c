"""A film of the field files of a run, drawn by scene.py: a picture for each instant.

The files are read twice: first for the box around all parts and the range of colours over all
instants, which every picture has, then to draw them. A GIF is kept in memory as pictures of 255
colours, an MP4 file is written by ffmpeg as it is drawn.
"""
import pathlib

from trackbed_post import film_files, grids, instants, read, scene, still, write

FRAMES = 200  # at most, unless another number is given


def survey_of(shots, parts):
    """The grids.Survey over all instants."""
    files = {part: path for shot in shots for part, path in shot.files.items()}
    survey = grids.Survey(still.first_part(files, parts))
    for shot in shots:
        survey.add(shot.files)
    if not survey.boxes:
        raise read.Unreadable("the field files have no cells: choose other --parts, another "
                              "--stage or --time")
    return survey


def pictures(shots, window):
    pace = film_files.pace([shot.time for shot in shots])
    for shot in shots:
        window.show(grids.read_grids(shot.files))
        yield window.picture(", ".join(filter(None, (shot.label(), pace))))


def film(folder, path, choices, remark=""):
    """Writes the film of a run. `choices`: array, view, parts, stage, time, limits, x, frames;
    `remark`: why it is not another film."""
    film_files.require_name(path)
    found = instants.within(instants.of_run(folder, choices.parts), choices.stage, choices.time)
    shots = instants.thinned(found, choices.frames or FRAMES)
    write.folder(pathlib.Path(path).resolve().parent)
    scene.with_screen()
    if remark:
        print(remark)
    survey = survey_of(shots, choices.parts)
    colouring = survey.colouring(choices.array, choices.limits)
    few = f" of {len(found)}" if len(shots) < len(found) else ""
    print(f"{len(shots)}{few} instants from {shots[0].time:.6g} to {shots[-1].time:.6g} s: "
          f"{', '.join(survey.boxes)}; {colouring.part} coloured by {colouring.words()}",
          flush=True)
    drawn = pictures(shots, scene.Scene(survey, colouring, choices.view or scene.VIEW, choices.x,
                                        write.origin_or_name(folder)))
    content = film_files.encoded(path, drawn)
    write.whole(path, content)
    print(f"{path}: {write.size(len(content))}")
