// SPDX-License-Identifier: Apache-2.0
#pragma once
// Binary data that was sent as text: every CR LF pair in it became LF, and all values after one are shifted by a byte.

#include <cstddef>
#include <string>

namespace roadquery {

/// Puts the lost CRs of `values` big-endian floats (width 4) or doubles (8) back where that makes the values most
/// likely: a shortest path over the values (Viterbi 1967), whose state is the number of bytes lost so far. A value
/// costs -log of the share of its upper 16 bits among all in the block, a CR that of a pair of bytes. Returns how many
/// were put back; 0, with the data untouched, when nothing is missing, when pairs are there (then it was no text
/// transfer), when more than 60 are missing, or for more than 256 million values x missing: time and memory are that.
[[nodiscard]] std::size_t mend_newlines(std::string& data, std::size_t width, std::size_t values);

}  // namespace roadquery
