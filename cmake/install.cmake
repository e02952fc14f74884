# `cmake --install build/release --prefix P`. The tree may be moved afterwards: the tool looks for models and viewer
# relative to itself (core/find_resource.hpp), so the folders below P have fixed names.
install(TARGETS orthodrive orthodrive-train RUNTIME DESTINATION bin)
install(TARGETS fmu_roads fmu_car LIBRARY DESTINATION share/orthodrive/fmu)
install(DIRECTORY catalogue/ DESTINATION share/orthodrive/catalogue)
install(DIRECTORY models/ DESTINATION share/orthodrive/models PATTERN truth EXCLUDE)
# Built by `npm run build` or not: `orthodrive view` says when it is missing.
install(DIRECTORY viewer/dist/ DESTINATION share/orthodrive/viewer OPTIONAL)
install(FILES LICENSE cmake/third_party_licences.txt DESTINATION share/orthodrive/licences)

# The road library for simulators: C through the shared library, C++ through the static one. Found by pkg-config and by
# find_package(roadquery).
install(TARGETS roadquery_shared roadquery EXPORT roadquery LIBRARY DESTINATION lib ARCHIVE DESTINATION lib)
install(DIRECTORY src/roadquery DESTINATION include FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
configure_file(cmake/roadquery.pc.in roadquery.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/roadquery.pc DESTINATION lib/pkgconfig)
install(EXPORT roadquery NAMESPACE roadquery:: DESTINATION lib/cmake/roadquery FILE roadquery-config.cmake)
include(CMakePackageConfigHelpers)
write_basic_package_version_file(roadquery-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/roadquery-config-version.cmake DESTINATION lib/cmake/roadquery)
