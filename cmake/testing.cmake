# SPDX-License-Identifier: Apache-2.0
# Tests in tiers (docs/testing.md). A tier is a label of ctest: `quick` is what tools/test runs, `full` what tools/test --all
# runs besides.

# What a test does itself is little: -O1 takes a quarter less time to compile than -O3, and under sanitizers -O0 a quarter of that
# of -O2.
set(ORTHODRIVE_TEST_FLAGS ${ORTHODRIVE_WARNINGS} -Wno-dangling-else)  # in a unity build g++ no longer sees whose macros gtest's are
if(CMAKE_CXX_FLAGS MATCHES "-fsanitize=address")
  list(APPEND ORTHODRIVE_TEST_FLAGS -O0)
else()
  list(APPEND ORTHODRIVE_TEST_FLAGS ${ORTHODRIVE_COLD})
endif()

# Builds the programs of the quick tier: those that its commands name.
add_custom_target(quick_tests DEPENDS orthodrive)

# orthodrive_add_test(NAME N TIER quick|full COMMAND ... [PROPERTIES ...]): add_test with a tier.
function(orthodrive_add_test)
  cmake_parse_arguments(A "" "NAME;TIER" "COMMAND;PROPERTIES" ${ARGN})
  if(NOT A_TIER MATCHES "^(quick|full)$")
    message(FATAL_ERROR "test ${A_NAME}: TIER must be quick or full, not '${A_TIER}' (docs/testing.md)")
  endif()
  add_test(NAME ${A_NAME} COMMAND ${A_COMMAND})
  set_tests_properties(${A_NAME} PROPERTIES LABELS ${A_TIER} ${A_PROPERTIES})
  # Threads of libtorch that wait for each other would keep cores busy on which other tests could run.
  set_property(TEST ${A_NAME} APPEND PROPERTY ENVIRONMENT_MODIFICATION OMP_WAIT_POLICY=set:passive)
  set_property(GLOBAL APPEND PROPERTY ORTHODRIVE_TIERED ${A_NAME})
  if(A_TIER STREQUAL quick)
    string(REGEX MATCHALL "TARGET_FILE:[A-Za-z0-9_-]+" NAMED "${A_COMMAND}")
    list(TRANSFORM NAMED REPLACE "TARGET_FILE:" "")
    list(GET A_COMMAND 0 PROGRAM)
    foreach(TARGET ${PROGRAM} ${NAMED})
      if(TARGET ${TARGET})
        add_dependencies(quick_tests ${TARGET})
      endif()
    endforeach()
  endif()
endfunction()

# Ends the configuration when a test of these folders, or below them, has no tier.
function(orthodrive_check_tiers)
  get_property(TIERED GLOBAL PROPERTY ORTHODRIVE_TIERED)
  foreach(FOLDER ${ARGN})
    get_property(TESTS DIRECTORY ${FOLDER} PROPERTY TESTS)
    list(REMOVE_ITEM TESTS ${TIERED})
    if(TESTS)
      message(FATAL_ERROR "${FOLDER}: tests without a tier: ${TESTS}. Use orthodrive_add_test (docs/testing.md)")
    endif()
    get_property(BELOW DIRECTORY ${FOLDER} PROPERTY SUBDIRECTORIES)
    if(BELOW)
      orthodrive_check_tiers(${BELOW})
    endif()
  endforeach()
endfunction()

# The suites of the sources, as TEST, TEST_F and TEST_P name them.
function(orthodrive_suites_of OUT)
  set(SUITES)
  foreach(SOURCE ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${SOURCE})
    file(STRINGS ${SOURCE} LINES REGEX "^(TEST|TEST_F|TEST_P)\\(")
    foreach(LINE ${LINES})
      string(REGEX REPLACE "^[A-Z_]+\\(([A-Za-z0-9_]+),.*" "\\1" SUITE "${LINE}")
      list(APPEND SUITES ${SUITE})
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES SUITES)
  set(${OUT} ${SUITES} PARENT_SCOPE)
endfunction()

# Registers a program of gtest with ctest as NAME: all suites in one entry; with SUITES each in its own, NAME.SUITE, so that
# several cores share them. A suite is one process: what its SetUpTestSuite makes is made once. FULL names the suites that the quick
# tier leaves out, TIER the tier of the others. Among entries of their own is one, NAME.all_named, that fails when the program has
# a suite that none of them names. The output of a failure names the case.
function(orthodrive_register_suites NAME)
  cmake_parse_arguments(A "SUITES" "TIER;TIMEOUT" "FULL;PROPERTIES" ${ARGN})
  get_target_property(SOURCES test_${NAME} SOURCES)
  list(FILTER SOURCES INCLUDE REGEX "_test\\.cpp$")
  list(TRANSFORM SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ REGEX "^[^/]")
  orthodrive_suites_of(SUITES ${SOURCES})
  foreach(SUITE ${A_FULL})
    if(NOT SUITE IN_LIST SUITES)
      message(FATAL_ERROR "${NAME}: FULL names ${SUITE}, which is no suite of it")
    endif()
  endforeach()
  set(PROPERTIES TIMEOUT ${A_TIMEOUT} ${A_PROPERTIES})
  if(A_SUITES)
    foreach(SUITE ${SUITES})
      set(TIER ${A_TIER})
      if(SUITE IN_LIST A_FULL)
        set(TIER full)
      endif()
      orthodrive_add_test(NAME ${NAME}.${SUITE} TIER ${TIER} PROPERTIES ${PROPERTIES}
        COMMAND test_${NAME} --gtest_brief=1 "--gtest_filter=${SUITE}.*:*/${SUITE}.*")
    endforeach()
    string(REPLACE ";" ":" SUITES "${SUITES}")
    orthodrive_add_test(NAME ${NAME}.all_named TIER ${A_TIER} COMMAND test_${NAME} "--suites=${SUITES}")
  elseif(A_FULL)
    message(FATAL_ERROR "${NAME}: FULL needs SUITES")
  else()
    orthodrive_add_test(NAME ${NAME} TIER ${A_TIER} PROPERTIES ${PROPERTIES} COMMAND test_${NAME} --gtest_brief=1)
  endif()
endfunction()

# A test program: every *.cpp of the folder but those that LEAVE_OUT names.
function(orthodrive_test_program NAME)
  cmake_parse_arguments(A "" "" "DEPS;LIBS;LEAVE_OUT" ${ARGN})
  file(GLOB SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(TRANSFORM A_LEAVE_OUT PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  list(REMOVE_ITEM SOURCES ${A_LEAVE_OUT})
  list(TRANSFORM A_DEPS PREPEND orthodrive::)
  add_executable(test_${NAME} ${SOURCES})
  target_include_directories(test_${NAME} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_options(test_${NAME} PRIVATE ${ORTHODRIVE_TEST_FLAGS})
  target_link_libraries(test_${NAME} PRIVATE ${A_DEPS} ${A_LIBS} orthodrive_test_paths orthodrive_test_main)
  if(NOT NAME STREQUAL core)  # gtest costs seconds a file: one precompiled header serves all tests
    target_precompile_headers(test_${NAME} REUSE_FROM test_core)
  endif()
endfunction()

# A test program and its entries. FIXTURE is a ctest fixture that must have run before (sites built by tests/pipeline). SUITES, TIER,
# FULL and LEAVE_OUT: as above.
function(orthodrive_test NAME)
  cmake_parse_arguments(A "SUITES" "TIER;TIMEOUT;FIXTURE" "DEPS;LIBS;FULL;LEAVE_OUT" ${ARGN})
  orthodrive_test_program(${NAME} DEPS ${A_DEPS} LIBS ${A_LIBS} LEAVE_OUT ${A_LEAVE_OUT})
  if(NOT A_TIMEOUT)
    set(A_TIMEOUT 600)
  endif()
  set(SUITES)
  if(A_SUITES)
    set(SUITES SUITES)
  endif()
  set(FIXTURE)
  if(A_FIXTURE)
    set(FIXTURE PROPERTIES FIXTURES_REQUIRED ${A_FIXTURE})
  endif()
  orthodrive_register_suites(${NAME} ${SUITES} TIER "${A_TIER}" TIMEOUT ${A_TIMEOUT} FULL ${A_FULL} ${FIXTURE})
endfunction()
