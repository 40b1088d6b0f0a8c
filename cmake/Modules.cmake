# Headers that most files include, parsed once: they halve the time to compile a small file. Several
# files of a module, or of a folder of tests, are compiled as one (CMAKE_UNITY_BUILD): names in
# unnamed namespaces must therefore be unique in a module, and each test has a namespace of its own.
# Files must include what they use all the same: the preset debug compiles each alone, without
# precompiled headers.
set(TRACKBED_COMMON_HEADERS <algorithm> <array> <cmath> <cstdint> <functional> <map> <memory>
    <optional> <span> <string> <vector> <fmt/format.h> <Eigen/Core> <Eigen/Geometry>)

# trackbed_module(<name> [EXCEPT <ending>] [LINKS <target>...])
# A module is a static library of all .cpp files of its folder, but for those whose names have the
# given ending. It can include the interfaces
# (include/) of all modules; tests/style/layering.py checks which ones it may use.
function(trackbed_module name)
  cmake_parse_arguments(MODULE "" "EXCEPT" "LINKS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(MODULE_EXCEPT)
    list(FILTER sources EXCLUDE REGEX "${MODULE_EXCEPT}$")
  endif()
  add_library(${name} STATIC ${sources})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR}/include
                                     PRIVATE ${CMAKE_SOURCE_DIR}/src)
  target_link_libraries(${name} PUBLIC Eigen3::Eigen fmt::fmt PRIVATE trackbed_options)
  target_link_libraries(${name} PUBLIC ${MODULE_LINKS})
  if(name STREQUAL core)
    target_precompile_headers(core PRIVATE ${TRACKBED_COMMON_HEADERS})
  else()
    target_precompile_headers(${name} REUSE_FROM core)
  endif()
endfunction()

# The environment of every test: Open MPI refuses root unless allowed, and ranks that share a core
# must yield to each other. Transports are limited to those within one machine, which shortens each
# start. Leaks are not checked, as Open MPI keeps memory to the end.
set(TRACKBED_TEST_ENVIRONMENT OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_pml=ob1 OMPI_MCA_btl=self,vader
    ASAN_OPTIONS=detect_leaks=0 PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg)
if(TRACKBED_SANITIZE)  # scripts that limit the memory of a program do not limit that of sanitizers
  list(APPEND TRACKBED_TEST_ENVIRONMENT TRACKBED_SANITIZED=1
       TSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/support/threads.txt)
endif()

# Property of scripts whose runs on two ranks and more take most of the time. A waiting rank yields
# its core; if another test takes it, the rank gets it back only after milliseconds, at each
# message. So one processor more than ranks: on two cores tests/run.sh starts nothing beside them.
set(TRACKBED_OF_RANKS PROCESSORS 3)

# trackbed_sweep(<test> COMMAND <word>... [EVERY <n>] [FIRST <k>] [PROPERTIES <name> <value>...])
# A script with many cases. The test takes every nth of them from number k on; <test>_of_all, in the
# long tier, takes all (tests/support/part.py). Without EVERY there is only the first. Scripts may
# also choose by `some`, for example numbers of ranks; they then only distinguish EVERY 1.
function(trackbed_sweep name)
  cmake_parse_arguments(SWEEP "" "EVERY;FIRST" "COMMAND;PROPERTIES" ${ARGN})
  set(forms ${name})
  if(SWEEP_EVERY)
    list(APPEND forms ${name}_of_all)
  endif()
  foreach(form ${forms})
    add_test(NAME ${form} COMMAND ${SWEEP_COMMAND} WORKING_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    # Both forms write to the same folder.
    set_tests_properties(${form} PROPERTIES RESOURCE_LOCK ${name} ${SWEEP_PROPERTIES}
      ENVIRONMENT "${TRACKBED_TEST_ENVIRONMENT}")
  endforeach()
  if(SWEEP_EVERY)
    set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT TRACKBED_EVERY=${SWEEP_EVERY})
    if(SWEEP_FIRST)
      set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT TRACKBED_FIRST=${SWEEP_FIRST})
    endif()
    set_tests_properties(${name}_of_all PROPERTIES LABELS study TIMEOUT 3600)
  endif()
endfunction()

# Where tests write their runs. tests/run.sh makes it a link to memory if there is enough: each
# checkpoint waits for the disk, which takes a third of the time of a short run.
set(TRACKBED_TEST_RUNS ${CMAKE_BINARY_DIR}/tests/runs)

# Where tests with the label verify write the rows of docs/verification.md.
set(TRACKBED_VERIFICATION ${CMAKE_BINARY_DIR}/verification)

# trackbed_test(<file without .cpp> RANKS <n>... LINKS <module>... [LABELS <label>...]
#               [LONG <n>...] [TIMEOUT <s>])
# The tests of a file, run once for each number of ranks as <file>_on_<n>. The long tier runs the
# numbers of ranks in LONG. If 3 is among RANKS, it also runs all others but 1: on 3 ranks, the
# least number for which a part has two neighbours, the same code runs as on more. The files of a
# folder are one executable, <folder above>_<folder>_tests, since each costs a link.
function(trackbed_test name)
  cmake_parse_arguments(TEST "" "TIMEOUT" "RANKS;LINKS;LABELS;LONG" ${ARGN})
  if(NOT TEST_RANKS)
    message(FATAL_ERROR "trackbed_test(${name}): without RANKS the test would never run")
  endif()
  file(RELATIVE_PATH program ${CMAKE_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
  string(REPLACE "/" "_" program ${program}_tests)
  if(NOT TARGET ${program})
    add_executable(${program})
    target_link_libraries(${program} PRIVATE test_support trackbed_options)
    target_precompile_headers(${program} REUSE_FROM test_support)
    target_include_directories(${program} PRIVATE ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/tests)
    set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  endif()
  target_sources(${program} PRIVATE ${name}.cpp)
  target_link_libraries(${program} PRIVATE ${TEST_LINKS})
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 300)
  endif()
  if(3 IN_LIST TEST_RANKS)
    list(APPEND TEST_LONG ${TEST_RANKS})
    list(REMOVE_ITEM TEST_LONG 1 3)
  endif()
  foreach(ranks ${TEST_RANKS})
    set(test ${name}_on_${ranks})
    set(environment "${TRACKBED_TEST_ENVIRONMENT}" TRACKBED_SOURCE=${CMAKE_SOURCE_DIR})
    if(ranks EQUAL 1)  # without mpirun, see alone() of tests/support/program.py
      set(start "")
      list(APPEND environment OMPI_MCA_ess_singleton_isolated=1
           OMPI_MCA_orte_tmpdir_base=${TRACKBED_TEST_RUNS}/session_${test})
    else()
      set(start ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} --oversubscribe
          --bind-to none)
    endif()
    add_test(NAME ${test} COMMAND ${start} $<TARGET_FILE:${program}> --file ${name}
      WORKING_DIRECTORY ${TRACKBED_TEST_RUNS})
    set(processors ${ranks})
    if(ranks GREATER 1)
      math(EXPR processors "${ranks} + 1")  # see TRACKBED_OF_RANKS
    endif()
    set_tests_properties(${test} PROPERTIES PROCESSORS ${processors} TIMEOUT ${TEST_TIMEOUT}
      LABELS "${TEST_LABELS}"
      ENVIRONMENT "${environment}")
    if("verify" IN_LIST TEST_LABELS)
      set_property(TEST ${test} APPEND PROPERTY
                   ENVIRONMENT "TRACKBED_VERIFICATION=${TRACKBED_VERIFICATION}")
    endif()
    if(ranks IN_LIST TEST_LONG)
      set_property(TEST ${test} APPEND PROPERTY LABELS study)
    elseif("verify" IN_LIST TEST_LABELS)
      set_tests_properties(${test} PROPERTIES FIXTURES_SETUP verification)
    endif()
  endforeach()
endfunction()
