// SPDX-License-Identifier: Apache-2.0
#pragma once
// What went wrong, sorted by who can fix it. Caught once, in app/main.cpp.

#include <stdexcept>
#include <string>

namespace orthodrive {

/// Cannot go on. Exit code 1.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The user's arguments or options are wrong. Exit code 2.
struct OptionError : Error {
  using Error::Error;
};

/// The user's data is wrong. Exit code 1. The message reads "file: what, what to do".
struct InputError : Error {
  InputError(const std::string& file, const std::string& what) : Error(file + ": " + what) {}
};

}  // namespace orthodrive
