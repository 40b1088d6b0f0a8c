"""The files that the checks of this folder read: those tracked by git, or all without git."""
import pathlib
import subprocess

SKIPPED = {"build", "results", ".git", "__pycache__", ".pytest_cache"}


def files(root):
    """Sorted paths relative to `root`."""
    # A clone may belong to another user than the one who tests, which git must accept.
    listing = subprocess.run(["git", "-c", "safe.directory=*", "-C", root, "ls-files", "-z"],
                             capture_output=True, text=True, check=False)
    if listing.returncode == 0 and listing.stdout:
        names = [pathlib.Path(name) for name in listing.stdout.split("\0") if name]
    else:
        names = [path.relative_to(root) for path in pathlib.Path(root).rglob("*")
                 if not SKIPPED & set(path.relative_to(root).parts)]
    return sorted(name for name in names if (pathlib.Path(root) / name).is_file())
