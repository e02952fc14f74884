#pragma once
// Weak labels: for every pixel the set of classes it may have, as bits. One bit is an ordinary label, no bit means that
// nothing is known there.

#include <cstdint>
#include <span>
#include <vector>

namespace orthodrive {

using ClassSet = std::uint8_t;  ///< bit c is set when class c is possible
constexpr ClassSet unknown_class = 0;

[[nodiscard]] constexpr ClassSet only(int label) { return static_cast<ClassSet>(1U << static_cast<unsigned>(label)); }

/// Loss of a pixel: -log of the probability of its allowed classes together, softmax over the scores. With one allowed
/// class it is the cross entropy; with several it leaves open which of them it is.
struct AllowedLossOptions {
  std::vector<float> class_weights;  ///< for pixels with one allowed class, by class
  float set_weight = 1.0F;           ///< for pixels with several
};

/// `scores`: pixels x classes, `allowed`: one set a pixel. Returns the weighted mean over the known pixels (0 when
/// there are none) and writes its derivative by the scores.
[[nodiscard]] double allowed_class_loss(std::span<const float> scores, std::span<const ClassSet> allowed,
                                        const AllowedLossOptions& options, std::span<float> gradient);

/// How labels agree with weak labels: ordinary counts on pixels with one allowed class; a label outside a set of
/// several is a false positive of that label.
class LabelScore {
 public:
  explicit LabelScore(int class_count);
  void add(std::span<const std::uint8_t> labels, std::span<const ClassSet> allowed);
  [[nodiscard]] double iou(int label) const;  ///< NaN for a class that no pixel is known to have
  [[nodiscard]] double mean_iou() const;      ///< over the classes in the truth
  [[nodiscard]] double pixel_accuracy() const;

 private:
  std::vector<std::uint64_t> hit_, missed_, wrong_;
  std::uint64_t known_ = 0, right_ = 0;
};

}  // namespace orthodrive
