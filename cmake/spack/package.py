"""Recipe for Spack 1.0: packages/trackbed/package.py of a repository of recipes of your own."""
from spack.package import *
from spack_repo.builtin.build_systems.cmake import CMakePackage


class Trackbed(CMakePackage):
    """Parallel simulation of ballasted railway track, from the train to the subgrade."""

    license("GPL-3.0-or-later")

    # From a folder with the source: spack develop --path FOLDER trackbed@main
    version("main", branch="main")

    variant("native", default=False, description="Use every instruction of the building machine")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("petsc@3.18: +mpi +hypre +metis +mumps ~complex ~int64")
    depends_on("hdf5@1.10: +mpi +hl")
    depends_on("metis")
    depends_on("eigen@3.4:3")
    depends_on("cgal@5.5:5 +header_only")
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
            self.define_from_variant("TRACKBED_NATIVE", "native"),
            self.define("HDF5_ROOT", self.spec["hdf5"].prefix),
        ]
