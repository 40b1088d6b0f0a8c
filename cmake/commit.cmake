# Writes the commit of the source into a header, which changes only with the commit:
#   cmake -DSOURCE=<folder> -DHEADER=<file> -P commit.cmake
set(commit "unknown")
find_program(GIT git)
# Not that of another repository in which an unpacked source lies.
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse --show-toplevel OUTPUT_VARIABLE top
                  ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  file(REAL_PATH ${SOURCE} source)
endif()
if(GIT AND top STREQUAL source)
  # --always: without tags, the abbreviated hash; --dirty: with uncommitted changes.
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty=-changed --exclude=*
                  OUTPUT_VARIABLE found ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE
                  RESULT_VARIABLE failed)
  if(NOT failed)
    set(commit ${found})
  endif()
endif()
set(text "#define TRACKBED_COMMIT \"${commit}\"\n")
set(old "")
if(EXISTS ${HEADER})
  file(READ ${HEADER} old)
endif()
if(NOT text STREQUAL old)
  file(WRITE ${HEADER} "${text}")
endif()
