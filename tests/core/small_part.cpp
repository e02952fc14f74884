// SPDX-License-Identifier: Apache-2.0
// A part of one number, for load_part_test.

extern "C" const int* orthodrive_part_small() {
  static const int seven = 7;
  return &seven;
}
