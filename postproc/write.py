"""Files that scripts make: whole or not there. What goes wrong ends the script with one sentence,
code 2 if another place mends it, 4 if the disk does not take the file."""
import errno
import os
import pathlib

import read

DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def reason_of(error):
    return error.strerror or str(error)


def folder(path):
    """Makes the folder if it is missing."""
    try:
        pathlib.Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        words = "is a file" if pathlib.Path(path).is_file() else reason_of(error)
        raise read.Unreadable(f"{path} cannot be made as a folder ({words}); choose another (-o)") \
            from None


def whole(path, content):
    """Writes bytes under another name first, so that an older file stays if there is no room."""
    path = pathlib.Path(path)
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        try:
            part.unlink(missing_ok=True)
        except OSError:
            pass  # the first reason is the one to tell
        ending = read.Unreadable(f"{path} cannot be written ({reason_of(error)})")
        ending.code = 4 if error.errno in DISK else 2
        raise ending from None
