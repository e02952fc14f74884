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
# Unity builds: g++ reads 16 files of a target in one go, which takes less than half of the time, as the headers are read and their
# templates instantiated once. So a name of an unnamed namespace is used once in a folder. Files with flags of their own stay
# apart, by CMake's rule. OFF for work on one file.
option(ORTHODRIVE_UNITY "compile many files of a target in one go" ON)
set(CMAKE_UNITY_BUILD ${ORTHODRIVE_UNITY})
set(CMAKE_UNITY_BUILD_BATCH_SIZE 16)
