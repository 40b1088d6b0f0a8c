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
# In a unity build the members of a class of one file may have types of its unnamed namespace.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(trackbed_options INTERFACE -Wno-subobject-linkage)
endif()
if(TRACKBED_WERROR)
  target_compile_options(trackbed_options INTERFACE -Werror)
endif()
if(TRACKBED_NATIVE)
  target_compile_options(trackbed_options INTERFACE -march=native)
endif()
if(TRACKBED_SANITIZE STREQUAL "thread")
  target_compile_options(trackbed_options INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
  target_link_options(trackbed_options INTERFACE -fsanitize=thread)
elseif(TRACKBED_SANITIZE)
  target_compile_options(trackbed_options INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(trackbed_options INTERFACE -fsanitize=address,undefined)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1")  # of the preset sanitize; with assertions
