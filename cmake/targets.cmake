# SPDX-License-Identifier: Apache-2.0
# One target a folder: orthodrive::<folder>. DEPS are other folders of ours, LIBS are third-party targets
# that stay private (they do not leak into who links us).
set(ORTHODRIVE_WARNINGS -Wall -Wextra -Wpedantic -Wno-missing-field-initializers
  -Wno-restrict  # g++ 12 false alarm on std::string operator+ (GCC bug 105651)
  $<$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>:-Wno-subobject-linkage>)  # a .cpp that is included looks like a header to g++

function(orthodrive_library NAME)
  cmake_parse_arguments(A "" "" "DEPS;LIBS" ${ARGN})
  file(GLOB SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(TARGET orthodrive_${NAME})
  list(TRANSFORM A_DEPS PREPEND orthodrive::)
  if(SOURCES)
    add_library(${TARGET} STATIC ${SOURCES})
    target_include_directories(${TARGET} PUBLIC ${PROJECT_SOURCE_DIR}/src)
    target_compile_options(${TARGET} PRIVATE ${ORTHODRIVE_WARNINGS})
    target_link_libraries(${TARGET} PUBLIC ${A_DEPS} PRIVATE ${A_LIBS})
  else()
    add_library(${TARGET} INTERFACE)
    target_include_directories(${TARGET} INTERFACE ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(${TARGET} INTERFACE ${A_DEPS} ${A_LIBS})
  endif()
  add_library(orthodrive::${NAME} ALIAS ${TARGET})
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
