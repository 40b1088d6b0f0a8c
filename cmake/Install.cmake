# cmake --install: the program, its decks, the post-processing, the documents and the completion of
# the command line; and Debian's package of these (preset `package`).
include(GNUInstallDirs)
set(trackbed_data ${CMAKE_INSTALL_DATADIR}/trackbed)
install(TARGETS trackbed RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY inputs DESTINATION ${trackbed_data})
install(DIRECTORY postproc DESTINATION ${trackbed_data} FILES_MATCHING PATTERN "*.py"
        PATTERN "*.toml" PATTERN py.typed PATTERN __pycache__ EXCLUDE)
install(PROGRAMS cmake/trackbed_post.sh RENAME trackbed_post DESTINATION ${CMAKE_INSTALL_BINDIR})
# Where the first line of each deck names it.
install(FILES docs/input.schema.json DESTINATION ${trackbed_data}/docs)
install(FILES README.md CHANGELOG.md CITATION.cff LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
# A link, so that ../inputs in the documents leads to the installed decks.
file(RELATIVE_PATH trackbed_decks "${CMAKE_INSTALL_FULL_DOCDIR}"
     "${CMAKE_INSTALL_PREFIX}/${trackbed_data}/inputs")
file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/installed")
file(CREATE_LINK "${trackbed_decks}" "${CMAKE_BINARY_DIR}/installed/inputs" SYMBOLIC)
install(FILES "${CMAKE_BINARY_DIR}/installed/inputs" DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES cmake/completion.bash RENAME trackbed
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)

# A package must run on other machines than the one that builds it.
if(NOT TRACKBED_NATIVE)
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_CONTACT "The trackbed authors")
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  # Shared libraries are found in the program; mpirun and the modules of Python are not.
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PACKAGE_DEPENDS openmpi-bin)
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
      "python3-h5netcdf, python3-h5py, python3-matplotlib, python3-numpy, python3-pil, \
python3-scipy, python3-vtk9, python3-xarray, xauth, xvfb")
  include(CPack)
endif()
