#!/usr/bin/env python3
"""The recipe for Spack depends on what CMake searches, and its list of Debian's packages has each.

    recipe.py [SOURCE_FOLDER]
"""
import pathlib
import re
import sys

CMAKE = ("CMakeLists.txt", "cmake/Dependencies.cmake")
RECIPE = "cmake/spack/spack_repo/trackbed/packages/trackbed/package.py"
DEBIAN = "cmake/spack/packages_debian.yaml"
# Names in CMake, in lower case and with - for _, that are not those of Spack.
SPACK = {"convex-hull-2": "cgal", "eigen3": "eigen", "hdf5-hl": "hdf5", "hdf5-openmpi": "hdf5"}
LANGUAGES = {"c", "cxx"}
# By what Debian provides it.
PROVIDERS = {"mpi": "openmpi", "pkgconfig": "pkgconf"}
GENERATOR = "ninja"  # of Spack's builds, not searched


def searched(text):
    """{package: least version, or nothing} of the commands of CMake."""
    text = re.sub(r"#.*", "", text)
    found = {"cmake": version for version in re.findall(
        r"cmake_minimum_required\(VERSION ([\d.]+)", text)}
    for name, version in (re.findall(r"find_package\((\w+)(?: ([\d.]+))?", text) +
                          re.findall(r"pkg_check_modules\(.*?([\w-]+)()\)", text) +
                          re.findall(r"find_library\(\w+ ([\w-]+)()", text) +
                          re.findall(r"find_path\(\w+ (?:\w+/)?(\w+)\.h()", text)):
        name = name.lower().replace("_", "-")
        name = SPACK.get(name, name)
        found[name] = version or found.get(name, "")
    return found


def check(root):
    """(problems, number of packages compared)."""
    needed = searched("".join((root / name).read_text(encoding="utf-8") for name in CMAKE))
    recipe = dict(re.findall(r'depends_on\("([\w-]+)(?:@([\d.]+))?',
                             (root / RECIPE).read_text(encoding="utf-8")))
    listed = set(re.findall(r"^  ([\w-]+):", (root / DEBIAN).read_text(encoding="utf-8"), re.M))
    problems = [f"{RECIPE}: lacks {name}, which CMake searches" for name in needed.keys() - recipe]
    problems += [f"{RECIPE}: {name} is not searched by CMake"
                 for name in recipe.keys() - needed - LANGUAGES - set(PROVIDERS.values())]
    problems += [f"{RECIPE}: {name} from {recipe[name] or 'any version'}, in CMake from {version}"
                 for name, version in needed.items()
                 if version and recipe.get(name, version) != version]
    provided = {PROVIDERS.get(name, name) for name in recipe.keys() - LANGUAGES} | {GENERATOR}
    problems += [f"{DEBIAN}: {name} is in only one of this list and the recipe"
                 for name in provided ^ listed]
    return sorted(problems), len(needed)


def main():
    problems, number = check(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve())
    print("\n".join(problems) if problems else f"the recipe has the {number} packages of CMake")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
