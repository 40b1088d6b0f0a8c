#!/usr/bin/env python3
"""The installed program and its files, and what it states of its origin.

    installed.py CMAKE BUILD_FOLDER FOLDER [PACKAGE_BUILD]

PACKAGE_BUILD: folder in which Debian's package is built from the source of BUILD_FOLDER and then
unpacked instead. The package is also installed on a fresh Debian (debootstrap, as root).
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, expect  # noqa: E402


# By build type, as in cmake/Options.cmake; that of Debug is CMake's.
OPTIMISATION = {"Release": "-O3", "RelWithDebInfo": "-O1", "Debug": "-g"}


def call(*words, **options):
    ran = subprocess.run([str(word) for word in words], check=False, capture_output=True, text=True,
                         **options)
    if ran.returncode:
        raise SystemExit(f"{words} ended with {ran.returncode}:\n{ran.stdout[-3000:]}\n"
                         f"{ran.stderr[-3000:]}")
    return ran


def unpacked(cmake, source, build, folder):
    """Builds the package and unpacks it without installing it; returns what corresponds to /usr."""
    call(cmake, "--preset", "package", "-B", build, cwd=source)
    call(cmake, "--build", build, "--target", "trackbed")
    cpack = pathlib.Path(cmake).parent / "cpack"
    call(cpack, "--config", build / "CPackConfig.cmake", "-B", folder)
    package, = folder.glob("*.deb")
    fields = call("dpkg-deb", "--field", package).stdout
    for word in ("openmpi-bin", "libhdf5", "libpetsc", "Recommends: python3-h5netcdf"):
        if word not in fields:
            raise SystemExit(f"{package} does not name {word}:\n{fields}")
    call("dpkg-deb", "--extract", package, folder / "root")
    return folder / "root" / "usr"


def installed_on_debian(source, package, root):
    """Installs the package on a fresh Debian in the folder `root`, by the commands of the last
    stage of cmake/Containerfile, and runs a deck there on two ranks and the post-processing."""
    lists = list(pathlib.Path("/etc/apt/sources.list.d").glob("*.sources"))
    if not lists:
        raise SystemExit("no /etc/apt/sources.list.d/*.sources names the archive of Debian")
    address = re.search(r"^URIs: *(\S+)", lists[0].read_text(encoding="utf-8"), re.M).group(1)
    release = re.search(r"^VERSION_CODENAME=(\w+)", pathlib.Path("/etc/os-release").read_text(
        encoding="utf-8"), re.M).group(1)
    call("debootstrap", "--variant=minbase", release, root, address)
    for path in lists:
        shutil.copy(path, root / "etc/apt/sources.list.d")
    (root / "etc/apt/sources.list").unlink(missing_ok=True)
    (root / "package").mkdir()
    shutil.copy(package, root / "package")
    last = (source / "cmake/Containerfile").read_text(encoding="utf-8").split("\nFROM ")[-1]
    environment = {"PATH": os.environ["PATH"], "DEBIAN_FRONTEND": "noninteractive",
                   **dict(re.findall(r"(OMPI_\w+)=(\S+)", last))}

    def run(*words):
        return call("chroot", root, *words, env=environment).stdout
    commands = re.findall(r"^RUN (.*[^\\\\])$", last, re.M)
    if not commands:
        raise SystemExit("cmake/Containerfile installs nothing")
    for command in commands:
        run("bash", "-c", command)
    run("mpirun", "-n", "2", "--oversubscribe", "trackbed", "run",
        "/usr/share/trackbed/inputs/verify/stack.toml", "output.fields=true", "-o", "/results")
    run("trackbed_post", "still", "/results", "-o", "/still.png")
    if not (root / "still.png").read_bytes().startswith(b"\x89PNG"):
        raise SystemExit("trackbed_post still on a fresh Debian: no picture")
    listed = run("trackbed_post", "list", "/results")
    if "history/time" not in listed:
        raise SystemExit(f"trackbed_post list on a fresh Debian: {listed}")
    print(run("trackbed", "--version"))


def check_origin(program, place, optimisation):
    """The origin is the same in --version, in results and in checkpoints."""
    ran = program.done(1, "--version")
    name, build = ran.stdout.splitlines()
    expect(re.fullmatch(r"trackbed \d+\.\d+\.\d+", name), "name and version", ran)
    expect(re.fullmatch(rf"commit [0-9a-z-]+; \S+ [\d.]+ .*{optimisation}\b.*; .*\d.*; "
                        r"HDF5 [\d.]+, PETSc [\d.]+, Eigen [\d.]+", build),
           "commit, compiler with options, libraries", ran)
    info = program.done(1, "info", place / "results.h5")
    expect(build in info.stdout, "the results state the build", info)
    info = program.done(1, "info", place)
    expect(build in info.stdout, "the checkpoint states the build", info)
    return build


def check_pip(data, folder, results):
    """The package of Python is installed by pip from a copy, since pip writes beside its source."""
    shutil.copytree(data / "postproc", folder / "source")
    call(sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--no-build-isolation",
         "--target", folder / "site", folder / "source")
    listed = call(sys.executable, "-m", "trackbed_post", "list", results, cwd="/",
                  env={**os.environ, "PYTHONPATH": str(folder / "site")})
    if "history/time" not in listed.stdout:
        raise SystemExit(f"installed by pip, list: {listed.stdout}")


def check_completion(usr):
    """What is proposed for the last word of a line."""
    script = usr / "share/bash-completion/completions/trackbed"
    for line, wanted, unwanted in (
            ("re", "resume", "run"), ("run a.toml ground.elem", "ground.elements_x=", "dem."),
            ("run a.toml tit", "title=", "."), ("run a.toml stage.k", "", "stage.kind="),
            ("describe irreg", "irregularity", "="), ("resume --fo", "--force", "--output")):
        found = call("bash", "-c", f"compopt() {{ :; }}; source {script}; COMP_WORDS=(trackbed "
                     f"{line}); COMP_CWORD={len(line.split())}; _trackbed; echo ${{COMPREPLY[@]}}",
                     env={**os.environ, "PATH": f"{usr / 'bin'}:{os.environ['PATH']}"}).stdout
        if wanted not in found or unwanted in found:
            raise SystemExit(f"the completion proposes {found!r} for {line}")


def main():
    cmake, build, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    compiled = pathlib.Path(sys.argv[4]) if len(sys.argv) > 4 else build
    if len(sys.argv) > 4:
        source = pathlib.Path(__file__).resolve().parents[2]
        usr = unpacked(cmake, source, compiled, folder)
    else:
        call(cmake, "--install", build, "--prefix", folder / "usr")
        usr = folder / "usr"
    program, data = Program(str(usr / "bin/trackbed")), usr / "share/trackbed"
    place = folder / "run"
    # From another folder, with decks and scripts of the installation only.
    program.done(1, "run", data / "inputs/verify/stack.toml", "output.stop_after=20", "-o", place,
                 code=3)
    cache = (compiled / "CMakeCache.txt").read_text(encoding="utf-8")
    kind = re.search(r"^CMAKE_BUILD_TYPE:\w+=(\w+)$", cache, re.M)
    stated = check_origin(program, place, OPTIMISATION[kind[1]])
    if "-march=native" in stated and len(sys.argv) > 4:
        raise SystemExit(f"the package is for the processor of this machine: {stated}")
    listed = call(usr / "bin/trackbed_post", "list", place / "results.h5",
                  env={**os.environ, "TRACKBED_PYTHON": sys.executable})
    if "history/time" not in listed.stdout:
        raise SystemExit(f"trackbed_post list: {listed.stdout}")
    if len(sys.argv) > 4:
        check_pip(data, folder, place / "results.h5")
    for name in ("share/doc/trackbed/README.md", "share/doc/trackbed/docs/running.md",
                 "share/trackbed/docs/input.schema.json"):
        if not (usr / name).is_file():
            raise SystemExit(f"{name} is not installed")
    links = pathlib.Path(__file__).resolve().parents[1] / "style/links.py"
    call(sys.executable, links, usr / "share/doc/trackbed")
    check_completion(usr)
    if len(sys.argv) > 4:
        package, = folder.glob("*.deb")
        # Not below `folder`, which may be in memory, where no programs may be started.
        with tempfile.TemporaryDirectory(prefix="debian-", dir=build) as root:
            installed_on_debian(source, package, pathlib.Path(root))


if __name__ == "__main__":
    main()
