# One library per folder (or named subfolder), one test binary per folder under tests/unit.

# roseau_library(recorder/format SOURCES a.cpp ... USES core schema LINKS PkgConfig::ZSTD PRIVATE_LINKS ...)
# makes the target roseau_recorder_format, known as roseau::recorder/format's folder with '_' for '/'.
function(roseau_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES;LINKS;PRIVATE_LINKS" ${ARGN})
  string(REPLACE "/" "_" name ${folder})
  if(ARG_SOURCES)
    add_library(roseau_${name} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(roseau_${name} PRIVATE roseau_options ${ARG_PRIVATE_LINKS})
  else()
    add_library(roseau_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_include_directories(roseau_${name} ${scope} ${PROJECT_SOURCE_DIR})
  foreach(used IN LISTS ARG_USES)
    string(REPLACE "/" "_" used_name ${used})
    target_link_libraries(roseau_${name} ${scope} roseau_${used_name})
  endforeach()
  target_link_libraries(roseau_${name} ${scope} ${ARG_LINKS})
endfunction()

# roseau_test(core SOURCES ... USES core support LINKS ...): one GoogleTest binary, each test its own ctest entry.
# A test that calls GTEST_SKIP is counted as skipped in ctest's summary. LABELS hardware: not part of `./dev test`.
function(roseau_test folder)
  cmake_parse_arguments(ARG "" "TIMEOUT;LABELS" "SOURCES;USES;LINKS" ${ARGN})
  string(REPLACE "/" "_" name ${folder})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(test_${name} ${ARG_SOURCES})
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(test_${name} PRIVATE ROSEAU_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(test_${name} PRIVATE roseau_options GTest::gmock GTest::gtest_main ${ARG_LINKS})
  foreach(used IN LISTS ARG_USES)
    string(REPLACE "/" "_" used_name ${used})
    target_link_libraries(test_${name} PRIVATE roseau_${used_name})
  endforeach()
  set(labels "")
  if(ARG_LABELS)
    set(labels LABELS ${ARG_LABELS})
  endif()
  gtest_discover_tests(test_${name}
    TEST_PREFIX "${folder}/"
    DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT ${ARG_TIMEOUT} SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\]" ${labels})
endfunction()
