# SPDX-License-Identifier: Apache-2.0
# Debian packages by CPack, one a component of cmake/install.cmake. tools/package configures with ORTHODRIVE_PACKAGE=ON,
# CMAKE_INSTALL_PREFIX=/usr and, where it is known, ORTHODRIVE_COMMIT; docs/packaging.md.
set(ORTHODRIVE_MAINTAINER "Orthodrive maintainers <maintainers@orthodrive.invalid>" CACHE STRING "Name <address>, for packages")
set(ORTHODRIVE_PACKAGE_VERSION ${PROJECT_VERSION} CACHE STRING "version of the Debian packages")
set(LIBRARY_PACKAGE libroadquery${ROADQUERY_ABI})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME orthodrive)
set(CPACK_PACKAGE_VERSION ${ORTHODRIVE_PACKAGE_VERSION})
set(CPACK_PACKAGE_CONTACT ${ORTHODRIVE_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL orthodrive libroadquery libroadquery-dev)
if(ORTHODRIVE_LAB)
  list(APPEND CPACK_COMPONENTS_ALL orthodrive-lab orthodrive-parts)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib/orthodrive)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

# dpkg-shlibdeps finds the libraries and these bring their data (gdal-data, proj-data). ca-certificates: for sources behind https.
set(CPACK_DEBIAN_ORTHODRIVE_PACKAGE_NAME orthodrive)
set(CPACK_DEBIAN_ORTHODRIVE_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ORTHODRIVE_PACKAGE_DEPENDS proj-data)
set(CPACK_DEBIAN_ORTHODRIVE_PACKAGE_RECOMMENDS ca-certificates)
set(CPACK_DEBIAN_ORTHODRIVE_PACKAGE_SUGGESTS "orthodrive-lab, orthodrive-parts, qgis, xdg-utils")
set(CPACK_COMPONENT_ORTHODRIVE_DESCRIPTION "turns orthophotos and OpenStreetMap into drivable environments
Makes a semantic map, road centre lines and widths corrected from the photo,
smooth 3D roads, OpenDRIVE and OpenCRG for simulators, 3D Tiles for the eye,
and a simulated lap from an orthophoto, OpenStreetMap roads and a terrain
model. Holds the tool, its model, a viewer for the browser and functional
mock-up units (FMI 2.0 and 3.0) of roads and of a car.")

set(CPACK_DEBIAN_ORTHODRIVE-LAB_PACKAGE_NAME orthodrive-lab)
set(CPACK_DEBIAN_ORTHODRIVE-LAB_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ORTHODRIVE-LAB_PACKAGE_DEPENDS "orthodrive (= ${CPACK_PACKAGE_VERSION})")
set(CPACK_COMPONENT_ORTHODRIVE-LAB_DESCRIPTION "turns orthophotos into drivable environments - laboratory
What orthodrive is judged and tuned with: synthetic sites with exact truth,
weights of the refinement searched on sites with truth, and published methods
for roads and heights to compare with. Adds commands and methods to
orthodrive.")

if(ORTHODRIVE_LAB AND NOT (TARGET orthodrive_forests_so AND TARGET orthodrive_train_so))
  message(FATAL_ERROR "packages: the parts are not built, tools/setup --parts brings what they need")
endif()
set(CPACK_DEBIAN_ORTHODRIVE-PARTS_PACKAGE_NAME orthodrive-parts)
set(CPACK_DEBIAN_ORTHODRIVE-PARTS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ORTHODRIVE-PARTS_PACKAGE_DEPENDS "orthodrive-lab (= ${CPACK_PACKAGE_VERSION})")
# Version 0.1.0 of orthodrive had orthodrive-train in it.
set(CPACK_DEBIAN_ORTHODRIVE-PARTS_PACKAGE_REPLACES "orthodrive (<< ${CPACK_PACKAGE_VERSION})")
set(CPACK_DEBIAN_ORTHODRIVE-PARTS_PACKAGE_BREAKS "orthodrive (<< ${CPACK_PACKAGE_VERSION})")
set(CPACK_COMPONENT_ORTHODRIVE-PARTS_DESCRIPTION "turns orthophotos into drivable environments - learning and baselines
What of orthodrive needs libtorch or OpenCV: training a network, adapting it
to a site, and the random forests of a baseline for roads. The commands of
orthodrive load it when they need it. Holds orthodrive-train, too.")

set(CPACK_DEBIAN_LIBROADQUERY_PACKAGE_NAME ${LIBRARY_PACKAGE})
set(CPACK_DEBIAN_LIBROADQUERY_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_LIBROADQUERY_DESCRIPTION "real-time queries of OpenDRIVE road surfaces
Answers what lies under a wheel: height, normal, lane, friction and surface
of OpenDRIVE roads with OpenCRG grids and a terrain beside them. For
simulators that ask a thousand times a second and more.")
# Programs that link the library depend on this package; ldconfig runs after its installation.
set(CONTROL_FILES ${PROJECT_BINARY_DIR}/debian/${LIBRARY_PACKAGE})
file(WRITE ${CONTROL_FILES}/shlibs "libroadquery ${ROADQUERY_ABI} ${LIBRARY_PACKAGE} (>= ${PROJECT_VERSION})\n")
file(WRITE ${CONTROL_FILES}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBROADQUERY_PACKAGE_CONTROL_EXTRA ${CONTROL_FILES}/shlibs ${CONTROL_FILES}/triggers)

set(CPACK_DEBIAN_LIBROADQUERY-DEV_PACKAGE_NAME libroadquery-dev)
set(CPACK_DEBIAN_LIBROADQUERY-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBROADQUERY-DEV_PACKAGE_SHLIBDEPS OFF)
# The static library needs Expat's.
set(CPACK_DEBIAN_LIBROADQUERY-DEV_PACKAGE_DEPENDS "${LIBRARY_PACKAGE} (= ${CPACK_PACKAGE_VERSION}), libexpat1-dev")
set(CPACK_COMPONENT_LIBROADQUERY-DEV_DESCRIPTION "real-time queries of OpenDRIVE road surfaces - development files
Answers what lies under a wheel: height, normal, lane, friction and surface
of OpenDRIVE roads with OpenCRG grids and a terrain beside them.
Headers, the static library for C++, and what pkg-config and CMake look for.")

# What Debian wants beside: copyright, changelog, and reasons for what lintian would ask about.
string(TIMESTAMP RELEASE_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)  # follows SOURCE_DATE_EPOCH
foreach(COMPONENT ${CPACK_COMPONENTS_ALL})
  string(REGEX REPLACE "^libroadquery$" ${LIBRARY_PACKAGE} NAME ${COMPONENT})
  set(FOLDER ${PROJECT_BINARY_DIR}/debian/${NAME})
  configure_file(cmake/debian/changelog.in ${FOLDER}/changelog @ONLY)
  execute_process(COMMAND gzip -9nf ${FOLDER}/changelog COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${FOLDER}/changelog.gz cmake/debian/copyright DESTINATION share/doc/${NAME} COMPONENT ${COMPONENT})
  if(EXISTS ${PROJECT_SOURCE_DIR}/cmake/debian/${COMPONENT}.lintian)
    configure_file(cmake/debian/${COMPONENT}.lintian ${FOLDER}/${NAME} @ONLY)
    install(FILES ${FOLDER}/${NAME} DESTINATION share/lintian/overrides COMPONENT ${COMPONENT})
  endif()
endforeach()
include(CPack)
