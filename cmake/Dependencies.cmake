# Debian's packages, each as one imported target.
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS C CXX)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(tomlplusplus REQUIRED)
# Only CGAL's headers are used (hulls, meshes, exact predicates): its own CMake package would
# require Boost components and override build types.
find_path(CGAL_INCLUDE_DIR CGAL/convex_hull_2.h REQUIRED)
find_library(GMP_LIBRARY gmp REQUIRED)
find_library(MPFR_LIBRARY mpfr REQUIRED)
add_library(trackbed_cgal INTERFACE)
target_include_directories(trackbed_cgal SYSTEM INTERFACE ${CGAL_INCLUDE_DIR})
target_link_libraries(trackbed_cgal INTERFACE ${MPFR_LIBRARY} ${GMP_LIBRARY})

find_library(METIS_LIBRARY metis REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)  # header only
pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET PETSc)
# Options of Debian's own build (-D_FORTIFY_SOURCE), with which precompiled headers of modules
# without PETSc could not be used.
set_property(TARGET PkgConfig::PETSC PROPERTY INTERFACE_COMPILE_OPTIONS "")
# Debian's parallel HDF5 is known to pkg-config; elsewhere, or with HDF5_ROOT, CMake searches.
add_library(trackbed_hdf5 INTERFACE)
# Newer versions of HDF5 declare the functions of 1.10 with it.
target_compile_definitions(trackbed_hdf5 INTERFACE H5_USE_110_API)
if(NOT DEFINED HDF5_ROOT AND NOT DEFINED ENV{HDF5_ROOT})
  pkg_check_modules(DEBIAN_HDF5 QUIET IMPORTED_TARGET hdf5-openmpi)
endif()
if(DEBIAN_HDF5_FOUND)
  set(HDF5_VERSION ${DEBIAN_HDF5_VERSION})
  find_library(HDF5_HL_LIBRARY hdf5_hl HINTS ${DEBIAN_HDF5_LIBRARY_DIRS} REQUIRED)
  target_link_libraries(trackbed_hdf5 INTERFACE PkgConfig::DEBIAN_HDF5 ${HDF5_HL_LIBRARY})
else()
  set(HDF5_PREFER_PARALLEL TRUE)
  find_package(HDF5 1.10 REQUIRED COMPONENTS C HL)
  if(NOT HDF5_IS_PARALLEL)
    message(FATAL_ERROR "HDF5 ${HDF5_VERSION} (${HDF5_C_LIBRARIES}) was built without MPI. "
      "Install a parallel HDF5 and give its folder as HDF5_ROOT.")
  endif()
  target_include_directories(trackbed_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS})
  target_link_libraries(trackbed_hdf5 INTERFACE ${HDF5_HL_LIBRARIES} ${HDF5_C_LIBRARIES})
endif()

# Debian's python3, not the first on PATH: only Debian's has the modules of cmake/packages.txt.
set(TRACKBED_PYTHON /usr/bin/python3 CACHE FILEPATH "Python with h5py, numpy, matplotlib and VTK")
