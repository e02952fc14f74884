# SPDX-License-Identifier: Apache-2.0
# `cmake --install build/release --prefix P`. The tree may be moved afterwards: the tool looks for models, viewer and the
# libraries of FMUs relative to itself (core/find_resource.hpp), so bin, share and lib/orthodrive have fixed names. Below
# /usr the road library goes where the distribution keeps libraries (lib/x86_64-linux-gnu of Debian).
# Components: orthodrive (the tool), orthodrive-lab (the laboratory), orthodrive-parts (what needs libtorch or OpenCV, where it is built), libroadquery (what
# programs load), libroadquery-dev (what they are built with).
include(GNUInstallDirs)
install(TARGETS orthodrive RUNTIME DESTINATION bin COMPONENT orthodrive)
install(TARGETS orthodrive_library orthodrive_core_library LIBRARY DESTINATION lib/orthodrive COMPONENT orthodrive)
if(ORTHODRIVE_LAB)
  install(TARGETS orthodrive_lab_library LIBRARY DESTINATION lib/orthodrive COMPONENT orthodrive-lab)
endif()
foreach(PART forests train)
  if(TARGET orthodrive_${PART}_so)
    install(TARGETS orthodrive_${PART}_so LIBRARY DESTINATION lib/orthodrive/parts COMPONENT orthodrive-parts)
  endif()
endforeach()
if(TARGET orthodrive-train)
  install(TARGETS orthodrive-train RUNTIME DESTINATION bin COMPONENT orthodrive-parts)
endif()
install(TARGETS fmu_roads fmu_car LIBRARY DESTINATION lib/orthodrive/fmu COMPONENT orthodrive)
# What runs need. Labels, weights and experiments of the shipped training stay in the source tree: they name its data.
install(FILES models/default.safetensors models/default.toml models/default.md DESTINATION share/orthodrive/models COMPONENT orthodrive)
install(DIRECTORY models/classes models/networks models/vehicles DESTINATION share/orthodrive/models COMPONENT orthodrive)
install(DIRECTORY catalogue/ DESTINATION share/orthodrive/catalogue COMPONENT orthodrive)
# Built by `npm run build` or not: `orthodrive view` says when it is missing.
install(DIRECTORY viewer/dist/ DESTINATION share/orthodrive/viewer COMPONENT orthodrive OPTIONAL)
# The tool writes its manual pages and completions of shells itself.
set(HELP ${PROJECT_BINARY_DIR}/help)
install(CODE "execute_process(COMMAND \"$<TARGET_FILE:orthodrive>\" -q help-files \"${HELP}\" COMMAND_ERROR_IS_FATAL ANY)
  file(GLOB PAGES \"${HELP}/*.1\")
  execute_process(COMMAND gzip -9nf \${PAGES} COMMAND_ERROR_IS_FATAL ANY)" COMPONENT orthodrive)
install(DIRECTORY ${HELP}/ DESTINATION share/man/man1 COMPONENT orthodrive FILES_MATCHING PATTERN "*.1.gz")
install(FILES ${HELP}/orthodrive.bash DESTINATION share/bash-completion/completions RENAME orthodrive COMPONENT orthodrive)
set(ZSH_FOLDER $<IF:$<BOOL:${ORTHODRIVE_PACKAGE}>,vendor-completions,site-functions>)  # Debian keeps those of packages apart
install(FILES ${HELP}/orthodrive.zsh DESTINATION share/zsh/${ZSH_FOLDER} RENAME _orthodrive COMPONENT orthodrive)
install(FILES ${HELP}/orthodrive.fish DESTINATION share/fish/vendor_completions.d COMPONENT orthodrive)
if(NOT ORTHODRIVE_PACKAGE)  # Debian's packages say it in share/doc/NAME/copyright
  install(FILES LICENSE cmake/third_party_licences.txt DESTINATION share/orthodrive/licences COMPONENT orthodrive)
endif()

# The road library for simulators: C through the shared library, C++ through the static one. Found by pkg-config and by
# find_package(roadquery).
install(TARGETS roadquery_shared roadquery EXPORT roadquery
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libroadquery NAMELINK_COMPONENT libroadquery-dev
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libroadquery-dev)
install(DIRECTORY src/roadquery DESTINATION include COMPONENT libroadquery-dev FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(FILES ${ROADQUERY_HEADERS} DESTINATION include/roadquery COMPONENT libroadquery-dev)
file(RELATIVE_PATH PREFIX_FROM_PKGCONFIG /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/roadquery.pc.in roadquery.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/roadquery.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libroadquery-dev)
set(ROADQUERY_CMAKE ${CMAKE_INSTALL_LIBDIR}/cmake/roadquery)
install(EXPORT roadquery NAMESPACE roadquery:: DESTINATION ${ROADQUERY_CMAKE} FILE roadquery-config.cmake COMPONENT libroadquery-dev)
include(CMakePackageConfigHelpers)
write_basic_package_version_file(roadquery-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/roadquery-config-version.cmake DESTINATION ${ROADQUERY_CMAKE} COMPONENT libroadquery-dev)
