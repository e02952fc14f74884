# SPDX-License-Identifier: Apache-2.0
# Writes OUT, a source that says which build it is of: the version, and a hash of all headers and the compiler. Libraries of
# ours work together only where both are the same (core/load_part.hpp). Run as
# cmake -D ROOT=.. -D LAB=ON -D VERSION=.. -D COMPILER=.. -D OUT=.. -P build_id.cmake
file(GLOB_RECURSE HEADERS RELATIVE ${ROOT} ${ROOT}/src/*.hpp ${ROOT}/src/*.h ${ROOT}/src/*.inl)
if(LAB)
  file(GLOB_RECURSE OF_LAB RELATIVE ${ROOT} ${ROOT}/lab/*.hpp)
  list(APPEND HEADERS ${OF_LAB})
endif()
list(SORT HEADERS)
set(ALL ${COMPILER})
foreach(HEADER ${HEADERS})
  file(SHA256 ${ROOT}/${HEADER} HASH)
  string(APPEND ALL "${HEADER} ${HASH}\n")
endforeach()
string(SHA256 HASH "${ALL}")
string(SUBSTRING ${HASH} 0 8 HASH)
file(CONFIGURE OUTPUT ${OUT} CONTENT [=[
extern "C" {
extern const char orthodrive_build_id[];
[[gnu::used]] const char orthodrive_build_id[] = "|orthodrive-build|${VERSION} (interface ${HASH})|";
}
]=])
