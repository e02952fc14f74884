# SPDX-License-Identifier: Apache-2.0
# Which commit a build is of, for `orthodrive version`: tools/package names it; an archive of `git archive` carries it in
# cmake/commit.txt. Other builds record none, so that a commit
# alone builds nothing anew.
set(ORTHODRIVE_COMMIT "" CACHE STRING "commit that is built, for `orthodrive version`")
set(ORTHODRIVE_COMMIT_TEXT "${ORTHODRIVE_COMMIT}")
if(NOT ORTHODRIVE_COMMIT_TEXT)
  file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/commit.txt ARCHIVE_COMMIT REGEX "^[0-9a-f]+$")
  set(ORTHODRIVE_COMMIT_TEXT "${ARCHIVE_COMMIT}")
endif()
if(NOT ORTHODRIVE_COMMIT_TEXT)
  set(ORTHODRIVE_COMMIT_TEXT "not recorded (built in a source tree)")
endif()
