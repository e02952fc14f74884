// SPDX-License-Identifier: Apache-2.0
#pragma once
// Weak labels: for every pixel the set of classes it may have, as bits. One bit is an ordinary label, no bit means that
// nothing is known there.

#include <cstdint>
#include <span>
#include <vector>

namespace orthodrive {

using ClassSet = std::uint64_t;  ///< bit c is set when class c is possible
constexpr std::size_t max_classes = 64;
constexpr ClassSet unknown_class = 0;

[[nodiscard]] constexpr ClassSet only(int label) { return ClassSet{1} << static_cast<unsigned>(label); }

/// How labels agree with weak labels: ordinary counts on pixels with one allowed class; a label outside a set of
/// several is a false positive of that label.
class LabelScore {
 public:
  explicit LabelScore(int class_count);
  void add(std::span<const std::uint8_t> labels, std::span<const ClassSet> allowed);
  void add(const LabelScore& other);          ///< counts of another part, of as many classes
  [[nodiscard]] double iou(int label) const;  ///< NaN for a class that no pixel is known to have
  [[nodiscard]] double mean_iou() const;      ///< over the classes in the truth
  [[nodiscard]] double pixel_accuracy() const;

 private:
  std::vector<std::uint64_t> hit_, missed_, wrong_;
  std::uint64_t known_ = 0, right_ = 0;
};

}  // namespace orthodrive
