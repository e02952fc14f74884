// SPDX-License-Identifier: Apache-2.0
#pragma once
// What was meant by a word that is not known: for messages about keys, values and names that people type.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace orthodrive {

/// Number of letters to insert, drop, change or swap with their neighbour that make one text of the other (optimal
/// string alignment). Case does not count, nor does '-' against '_'.
[[nodiscard]] int edit_distance(std::string_view a, std::string_view b);

/// The known word closest to `word`, the first of equals; none when more than two fifths of its letters differ.
[[nodiscard]] std::optional<std::string> closest_word(std::string_view word, const std::vector<std::string>& known);

/// "; did you mean 'osm'?" or, where no word is close, "; known are: photo, osm, dtm".
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace orthodrive
