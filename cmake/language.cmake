# SPDX-License-Identifier: Apache-2.0
# The language of every project here, and ccache where it is installed. Included after project().
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
# No product and sum become one rounding unless the source says so: the same bits on processors with and without it.
add_compile_options(-ffp-contract=off)
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()
