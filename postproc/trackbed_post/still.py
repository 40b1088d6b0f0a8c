"""A picture of one instant: of one field file, of several, or of the parts that a run has.

Of one file all is coloured by one array (default: of stones their speed, else the first array that
is not constant). Of several, the first part is, and the others have plain colours. ParaView opens
the same files and has more options.
"""
import io
import os
import pathlib

from PIL import Image

from trackbed_post import grids, instants, passage_instant, read, scene, write

VIEWS, VIEW = tuple(scene.VIEWS), scene.VIEW


def chosen_files(sources, parts, time):
    """(part -> file, label) of files, or of the instant of a run that is nearest to a time, by
    default to that of passage_instant; of files the label is empty."""
    folders = [path for path in sources if os.path.isdir(path)]
    if folders and len(sources) > 1:
        raise read.Unreadable(f"{folders[0]} is a folder: give one folder or several field files")
    if folders:
        found = instants.of_run(folders[0], parts)
        if time is None:
            time = passage_instant.time_of(folders[0])
        instant = instants.nearest(found, time)
        return instant.files, instant.label()
    if parts is not None or time is not None:
        raise read.Unreadable("--parts and --time choose from the field files of a run: give its "
                              "folder instead of files")
    for path in sources:
        if not os.path.isfile(path):
            raise read.Unreadable(f"{path} does not exist or is not a file")
    return instants.of_files(sources), ""


def first_part(files, parts=None):
    """The part that is coloured: the first of those named, by default of the order of PARTS."""
    order = list(parts or instants.PARTS)
    return min(files, key=lambda part: order.index(part) if part in order else len(order))


def png(pixels):
    content = io.BytesIO()
    Image.fromarray(pixels).save(content, "PNG")
    return content.getvalue()


def render(sources, picture, choices):
    """Draws field files, or those of a run, into a PNG file; number of colours in it. `choices`:
    array, view, parts, time, limits, x."""
    if not picture.endswith(".png"):
        raise read.Unreadable(f"{picture}: the name of the picture must end in .png")
    files, label = chosen_files(sources, choices.parts, choices.time)
    write.folder(pathlib.Path(picture).parent)
    scene.with_screen()
    survey = grids.Survey(first_part(files, choices.parts if label else list(files)))
    drawn = survey.add(files)
    if survey.part not in drawn:
        raise read.Unreadable(f"the file of {survey.part} has no cells: choose other --parts or "
                              "another --time")
    colouring = survey.colouring(choices.array, choices.limits)
    window = scene.Scene(survey, colouring, choices.view or scene.VIEW, choices.x,
                         write.origin_or_name(sources[0]))
    window.show(drawn)
    colours = window.colours()
    label = label or instants.label_of(sources[0])
    write.whole(picture, png(window.picture(label)))
    what = f"{label}, {' '.join(drawn)}: " if label else ""
    print(f"{picture}: {what}{sum(grid.GetNumberOfCells() for grid in drawn.values())} cells; the "
          f"picture has {colours} different colours")
    if colours <= 1:
        plain = read.Unreadable("the picture is empty or of one colour: choose another --array")
        plain.code = 1
        raise plain
    return colours
