"""Which film a run has: of a transition zone, or of its field files."""
from trackbed_post import field_film, film_files, instants, kinds, read, transition, write

# Options that only a film of field files has.
OF_FIELDS = ("array", "view", "parts", "limits", "x", "stage", "time", "frames")


def is_transition(folder):
    """Whether the deck is that of a train over a transition zone, as far as a deck tells."""
    try:
        return "transition" in kinds.of_deck(read.origin(folder)[1])
    except read.Unreadable:
        return False  # a run that has written no results.h5 yet may have field files


def has_bodies(folder):
    return bool(set(instants.available(folder)) & set(instants.PARTS))


def write_film(given):
    """The film that suits the runs, or, with an option of OF_FIELDS, that of field files."""
    asked = given.fields or any(getattr(given, name) is not None for name in OF_FIELDS)
    if asked and len(given.results) > 1:
        raise read.Unreadable("give one result folder: a film of field files shows one run")
    if len(given.results) > 2:
        raise read.Unreadable("give one or two result folders")
    remark = ""
    if not asked and (len(given.results) == 2 or is_transition(given.results[0])):
        try:
            of_transition(given)
            return
        except read.Unreadable as why:
            if why.code != read.Unreadable.code or len(given.results) == 2 \
                    or not has_bodies(given.results[0]):
                raise
            remark = f"a film of the field files, since the transition zone has none: {why}"
    field_film.film(given.results[0], given.output, given, remark)


def of_transition(given):
    folders = [read.folder_of(one) for one in given.results]
    kinds.require_stones(folders, [read.origin(one)[1] for one in folders], "transition")
    film_files.require_name(given.output)
    pictures = transition.film_of(given.results, write.origin_of(given.results))
    content = film_files.encoded(given.output, pictures)
    write.folder(given.output.resolve().parent)
    write.whole(given.output, content)
    print(f"{given.output}: {write.size(len(content))}")
