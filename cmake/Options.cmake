# Flags common to all targets.
add_library(trackbed_options INTERFACE)
target_compile_options(trackbed_options INTERFACE
  -Wall -Wextra -Wpedantic -Wno-psabi
  # The same contact is computed on several ranks by differently inlined code, in which fused
  # multiply-adds chosen by the compiler would change the last bits. None of these flags changes a
  # value.
  -ffp-contract=off -fno-math-errno -fno-trapping-math -fopenmp-simd)
# GCC 12 reports parts of its own AVX-512 header, and of fmt's, as errors of the calling code
# (https://gcc.gnu.org/bugzilla/show_bug.cgi?id=105593); the sanitizer preset finds real ones.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(trackbed_options INTERFACE
    -Wno-uninitialized -Wno-maybe-uninitialized -Wno-stringop-overflow -Wno-restrict)
endif()
if(TRACKBED_WERROR)
  target_compile_options(trackbed_options INTERFACE -Werror)
endif()
if(TRACKBED_NATIVE)
  target_compile_options(trackbed_options INTERFACE -march=native)
endif()
if(TRACKBED_SANITIZE)
  target_compile_options(trackbed_options INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(trackbed_options INTERFACE -fsanitize=address,undefined)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3")

find_program(CCACHE ccache)
if(CCACHE)
  # Without these settings ccache does not cache files with precompiled headers.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(trackbed_options INTERFACE -fpch-preprocess)
  endif()
endif()
