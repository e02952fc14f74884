# SPDX-License-Identifier: Apache-2.0
# One target for each room: orthodrive::<room>. FOLDERS are its own, in the order of their arrows: a file includes those before its
# own, and what lies in the room itself includes all (tests/includes). DEPS are other rooms, LIBS are third-party targets
# that stay private (they do not leak into who links us). PART_SOURCES lie in the folder and belong to the part PART of
# orthodrive_part() instead. APART are files that alone need APART_FLAGS and APART_LIBS. A COLD room takes little of the time of a
# build of a site: it is compiled in three quarters of the time. Rooms of the laboratory (lab/orthodrive) lie in its library.
set(ORTHODRIVE_COLD $<$<CONFIG:Release>:-O1>)
set(ORTHODRIVE_WARNINGS -Wall -Wextra -Wpedantic -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  list(APPEND ORTHODRIVE_WARNINGS
    -Wno-restrict  # g++ 12 false alarm on std::string operator+ (GCC bug 105651)
    $<$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>:-Wno-subobject-linkage>)  # a .cpp that is included looks like a header to g++
endif()

function(orthodrive_library NAME)
  cmake_parse_arguments(A "COLD" "PART" "FOLDERS;DEPS;LIBS;PART_SOURCES;APART;APART_FLAGS;APART_LIBS" ${ARGN})
  file(GLOB_RECURSE SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(TRANSFORM A_PART_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  list(TRANSFORM A_APART PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  list(REMOVE_ITEM SOURCES ${A_PART_SOURCES} ${A_APART})
  list(FILTER SOURCES EXCLUDE REGEX "/part_[a-z]+\\.cpp$")  # the table of a part
  set_property(GLOBAL APPEND PROPERTY ORTHODRIVE_PART_SOURCES_${A_PART} ${A_PART_SOURCES})
  set(TARGET orthodrive_${NAME})
  set(INCLUDES ${PROJECT_SOURCE_DIR}/src)
  set(LIBRARY ORTHODRIVE)
  if(CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/lab/")
    list(APPEND INCLUDES ${PROJECT_SOURCE_DIR}/lab)
    set(LIBRARY ORTHODRIVE_LAB)
  endif()
  list(TRANSFORM A_DEPS PREPEND orthodrive::)
  if(SOURCES)
    set(FLAGS ${ORTHODRIVE_WARNINGS})
    if(A_COLD)
      list(APPEND FLAGS ${ORTHODRIVE_COLD})
    endif()
    add_library(${TARGET} STATIC ${SOURCES})
    target_include_directories(${TARGET} PUBLIC ${INCLUDES})
    target_compile_options(${TARGET} PRIVATE ${FLAGS})
    target_link_libraries(${TARGET} PUBLIC ${A_DEPS} PRIVATE ${A_LIBS} $<LINK_ONLY:${A_APART_LIBS}>)
    set(OBJECTS $<TARGET_OBJECTS:${TARGET}>)
    if(A_APART)
      add_library(${TARGET}_apart OBJECT ${A_APART})
      target_include_directories(${TARGET}_apart PRIVATE ${INCLUDES})
      target_compile_options(${TARGET}_apart PRIVATE ${FLAGS} ${A_APART_FLAGS})
      target_link_libraries(${TARGET}_apart PRIVATE ${A_DEPS} ${A_LIBS} ${A_APART_LIBS})
      target_sources(${TARGET} PRIVATE $<TARGET_OBJECTS:${TARGET}_apart>)
      list(APPEND OBJECTS $<TARGET_OBJECTS:${TARGET}_apart>)
    endif()
    if(NAME STREQUAL core)  # g++ reads the headers of the standard library once for all cold rooms, not for each of their files
      target_precompile_headers(${TARGET} PRIVATE <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory> <optional>
        <set> <span> <string> <vector> <fmt/format.h>)
    else()  # core is a library of its own
      set_property(GLOBAL APPEND PROPERTY ${LIBRARY}_OBJECTS ${OBJECTS})
      set_property(GLOBAL APPEND PROPERTY ${LIBRARY}_LIBS ${A_LIBS} ${A_APART_LIBS})
      if(A_COLD)  # g++ 12 reads a header of -O1 into a file of -O3 without a word, and crashes
        target_precompile_headers(${TARGET} REUSE_FROM orthodrive_core)
      endif()
    endif()
  else()
    add_library(${TARGET} INTERFACE)
    target_include_directories(${TARGET} INTERFACE ${INCLUDES})
    target_link_libraries(${TARGET} INTERFACE ${A_DEPS} ${A_LIBS})
  endif()
  add_library(orthodrive::${NAME} ALIAS ${TARGET})
endfunction()

# A shared library of ours below lib/orthodrive, of objects that are compiled already. It finds others of ours there.
function(orthodrive_shared_library TARGET KIND NAME FOLDER)
  add_library(${TARGET} ${KIND} ${ARGN} $<TARGET_OBJECTS:orthodrive_build_id>)
  file(RELATIVE_PATH UP /lib/orthodrive/${FOLDER} /lib/orthodrive)
  set_target_properties(${TARGET} PROPERTIES PREFIX "" OUTPUT_NAME ${NAME} LINKER_LANGUAGE CXX INSTALL_RPATH "\$ORIGIN/${UP}"
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib/orthodrive/${FOLDER})
  # Functions of the library call each other directly, as in a program.
  target_link_options(${TARGET} PRIVATE LINKER:-Bsymbolic-functions,--as-needed,--no-undefined)
endfunction()

# A part of the tool that a command loads when it needs it: lib/orthodrive/parts/NAME.so, of what the rooms have given to it and
# its table, lab/orthodrive/lab/commands/part_NAME.cpp. orthodrive::part_NAME is the same without the table for programs that link the rooms, such as
# tests. DEPS and LIBS as above.
function(orthodrive_part NAME)
  cmake_parse_arguments(A "" "" "DEPS;LIBS" ${ARGN})
  get_property(SOURCES GLOBAL PROPERTY ORTHODRIVE_PART_SOURCES_${NAME})
  list(TRANSFORM A_DEPS PREPEND orthodrive::)
  add_library(orthodrive_part_${NAME} STATIC ${SOURCES})
  add_library(orthodrive::part_${NAME} ALIAS orthodrive_part_${NAME})
  target_include_directories(orthodrive_part_${NAME} PUBLIC ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/lab)
  target_compile_options(orthodrive_part_${NAME} PRIVATE ${ORTHODRIVE_WARNINGS})
  target_link_libraries(orthodrive_part_${NAME} PUBLIC ${A_DEPS} PRIVATE ${A_LIBS})
  orthodrive_shared_library(orthodrive_${NAME}_so MODULE ${NAME} parts $<TARGET_OBJECTS:orthodrive_part_${NAME}>
    ${PROJECT_SOURCE_DIR}/lab/orthodrive/lab/commands/part_${NAME}.cpp)
  target_include_directories(orthodrive_${NAME}_so PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/lab)
  target_compile_options(orthodrive_${NAME}_so PRIVATE ${ORTHODRIVE_WARNINGS})
  target_link_libraries(orthodrive_${NAME}_so PRIVATE orthodrive_lab_library orthodrive_library orthodrive_core_library ${A_LIBS})
  add_dependencies(orthodrive_parts orthodrive_${NAME}_so)
endfunction()

# Inner loops that exist once per processor family, chosen at run time: NAME.cpp dispatches to NAME_plain, NAME_avx2 and
# NAME_avx512. All need fused multiply-add. -Wno-psabi: vectors are only passed to functions that are inlined.
function(orthodrive_cpu_kernels NAME)
  set(PLAIN)
  set_source_files_properties(${NAME}.cpp ${NAME}_plain.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(PLAIN -mfma)
    set_source_files_properties(${NAME}_avx2.cpp PROPERTIES COMPILE_OPTIONS "-Wno-psabi;-mavx2;-mfma")
    set_source_files_properties(${NAME}_avx512.cpp PROPERTIES COMPILE_OPTIONS
      "-Wno-psabi;-mavx2;-mfma;-mavx512f;-mavx512vl;-mavx512dq")
  else()
    set_source_files_properties(${NAME}_avx2.cpp ${NAME}_avx512.cpp PROPERTIES HEADER_FILE_ONLY ON)
  endif()
  set_source_files_properties(${NAME}_plain.cpp PROPERTIES COMPILE_OPTIONS "-Wno-psabi;${PLAIN}")
endfunction()
