"""Recipe for Spack 1.0 and later; docs/running.md states its commands."""
import pathlib

from spack_repo.builtin.build_systems.cmake import CMakePackage, generator

from spack.package import *


class Trackbed(CMakePackage):
    """Parallel simulation of ballasted railway track, from the train to the subgrade."""

    # The repository of this recipe, unless dev_path names a folder.
    git = pathlib.Path(__file__).parents[6].as_uri()

    license("GPL-3.0-or-later")

    version("main", branch="main")

    generator("ninja")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    # See Environment in src/par/comm.cpp.
    depends_on("openmpi +romio", when="^[virtuals=mpi] openmpi")
    # METIS: without it MUMPS, the direct solver, has only orders of unknowns with more fill.
    depends_on("petsc@3.18: +mpi +hypre +metis +mumps +double ~complex ~int64")
    depends_on("hdf5@1.10: +mpi +hl")
    depends_on("metis@5:")
    depends_on("eigen@3.4:3")
    depends_on("cgal@5.5:6")
    depends_on("gmp")
    depends_on("mpfr")
    depends_on("fmt@9:")
    depends_on("cli11@2:")
    depends_on("nlohmann-json@3.11:")
    depends_on("tomlplusplus@3.3:")
    depends_on("xxhash@0.8:")

    def cmake_args(self):
        return [
            self.define("BUILD_TESTING", False),
            self.define("CMAKE_UNITY_BUILD", True),
            # Spack's own compiler command adds -march for the target of the spec.
            self.define("TRACKBED_NATIVE", False),
            # Not the HDF5 of Debian that pkg-config knows.
            self.define("HDF5_ROOT", self.spec["hdf5"].prefix),
        ]
