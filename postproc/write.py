"""Writes files completely or not at all. An error ends the script with one message, with code 2 if
another path helps, with code 4 if the disk cannot take the file."""
import errno
import os
import pathlib

import read

DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def reason_of(error):
    return error.strerror or str(error)


def folder(path):
    """Creates the folder if it is missing."""
    try:
        pathlib.Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        words = "is a file" if pathlib.Path(path).is_file() else reason_of(error)
        raise read.Unreadable(f"{path} cannot be created as a folder ({words}); "
                              "choose another (-o)") \
            from None


def whole(path, content):
    """Writes bytes under another name first, so that an older file is kept if the disk is full."""
    path = pathlib.Path(path)
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        try:
            part.unlink(missing_ok=True)
        except OSError:
            pass  # the first reason is reported
        ending = read.Unreadable(f"{path} cannot be written ({reason_of(error)})")
        ending.code = 4 if error.errno in DISK else 2
        raise ending from None
