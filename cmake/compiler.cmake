# Language, warnings, sanitizers and linker: the same for every target of ours.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

set(ROSEAU_SANITIZE "" CACHE STRING "Comma-separated sanitizers: address,undefined or thread")
option(ROSEAU_FUZZ "Build the fuzzers (clang only)" OFF)

# Symbols in every build: a crash in the field must leave a readable trace.
string(APPEND CMAKE_CXX_FLAGS_RELEASE " -g1")

# Vector code for the machines in the field: x86-64-v2 (SSE4.2, every PC since 2009). Wider code is chosen at run time by
# the libraries that do the heavy work.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  add_compile_options(-march=x86-64-v2)
endif()

# No contraction to fused multiply-adds: results then do not depend on what the compiler found to fuse.
add_compile_options(-ffp-contract=off)

find_program(MOLD mold)
if(MOLD)
  add_link_options(-fuse-ld=mold)
endif()

add_library(roseau_options INTERFACE)
target_compile_options(roseau_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor -Woverloaded-virtual -Wold-style-cast
  -Wno-missing-field-initializers  # designated initialisers leave the rest at its default on purpose
  -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 takes "text" + std::string for overlapping memory (its bug 105651).
  target_compile_options(roseau_options INTERFACE -Wno-restrict)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND ROSEAU_SANITIZE)
  # g++ 12 sees ghosts in instrumented code.
  target_compile_options(roseau_options INTERFACE -Wno-maybe-uninitialized -Wno-stringop-overflow -Wno-array-bounds)
endif()

if(ROSEAU_SANITIZE)
  add_compile_options(-fsanitize=${ROSEAU_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${ROSEAU_SANITIZE})
endif()

if(ROSEAU_FUZZ)
  # Coverage in every library, so that the fuzzer sees where its input leads; the fuzzers themselves link its main.
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
