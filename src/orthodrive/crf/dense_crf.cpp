// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/dense_crf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "orthodrive/core/error.hpp"

namespace orthodrive {

namespace {

constexpr int strip_px =
    32;  // pixels are visited in strips this wide, so that the lattice vertices in use fit the cache

void check(const CrfWidths& widths) {
  for (const double theta : {widths.theta_alpha_px, widths.theta_beta, widths.theta_gamma_px})
    if (!(theta > 0.0 && std::isfinite(theta)))
      throw OptionError(fmt::format("dense CRF: kernel width {} is not a positive number", theta));
}

void check(const CrfParameters& p) {
  const auto classes = static_cast<std::size_t>(p.classes);
  if (p.classes < 1 || p.classes > max_crf_classes)
    throw OptionError(fmt::format("dense CRF: {} classes, 1 to {} are possible", p.classes, max_crf_classes));
  if (p.iterations < 0) throw OptionError(fmt::format("dense CRF: {} iterations", p.iterations));
  if (p.appearance_weight.size() != classes || p.smoothness_weight.size() != classes ||
      p.compatibility.size() != classes * classes)
    throw OptionError(fmt::format("dense CRF: {} + {} weights and {} compatibilities do not fit {} classes",
                                  p.appearance_weight.size(), p.smoothness_weight.size(), p.compatibility.size(),
                                  p.classes));
  if (!p.unary_compatibility.empty() && p.unary_compatibility.size() != classes * classes)
    throw OptionError(fmt::format("dense CRF: {} unary compatibilities do not fit {} classes",
                                  p.unary_compatibility.size(), p.classes));
}

/// psi_u of all pixels, in one order of sums whatever the processor.
std::vector<float> unary_potentials(const CrfParameters& p, std::span<const float> unary) {
  const auto n = static_cast<std::size_t>(p.classes);
  std::vector<float> potentials(unary.size(), 0.0F);
  for (std::size_t pixel = 0; pixel < unary.size(); pixel += n)
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t x = 0; x < n; ++x) potentials[pixel + x] -= p.unary_compatibility[k * n + x] * unary[pixel + k];
  return potentials;
}

/// From the derivatives by psi_u, which lie in `result.unary`, to those by the unary and the compatibility.
void unary_backward(const CrfParameters& p, std::span<const float> unary, CrfGradients& result) {
  const auto n = static_cast<std::size_t>(p.classes);
  std::vector<double> sums(n * n, 0.0);
  std::vector<float> of_unary(n);
  for (std::size_t pixel = 0; pixel < unary.size(); pixel += n) {
    float* const of_potential = &result.unary[pixel];
    for (std::size_t k = 0; k < n; ++k) {
      of_unary[k] = 0.0F;
      for (std::size_t x = 0; x < n; ++x) {
        of_unary[k] -= p.unary_compatibility[k * n + x] * of_potential[x];
        sums[k * n + x] -= static_cast<double>(of_potential[x]) * static_cast<double>(unary[pixel + k]);
      }
    }
    std::copy(of_unary.begin(), of_unary.end(), of_potential);
  }
  result.unary_compatibility.assign(sums.begin(), sums.end());
}

/// Uninitialised floats that grow when more are asked for. Lattices of whole windows are read all over the place: with
/// pages of 2 MB there are far fewer translations to look up, and the system hands them out faster.
class HugeArray {
 public:
  [[nodiscard]] float* of_size(std::size_t floats) {
    if (floats > size_ || data_ == nullptr) allocate(floats);
    return data_.get();
  }

 private:
  void allocate(std::size_t floats) {
    constexpr std::size_t page = std::size_t{1} << 21;
    const std::size_t bytes = floats * sizeof(float), alignment = bytes >= page ? page : 64;
    const std::size_t rounded = (std::max<std::size_t>(bytes, 1) + alignment - 1) / alignment * alignment;
    data_.reset();
    data_.reset(static_cast<float*>(std::aligned_alloc(alignment, rounded)));
    if (data_ == nullptr) throw std::bad_alloc();
    size_ = rounded / sizeof(float);
#if defined(__linux__)
    if (alignment == page) madvise(data_.get(), rounded, MADV_HUGEPAGE);  // a hint: failure costs only time
#endif
  }
  struct Free {
    void operator()(float* p) const { std::free(p); }
  };
  std::unique_ptr<float, Free> data_;
  std::size_t size_ = 0;
};

/// Values at the vertices of both lattices.
struct LatticeValues {
  HugeArray appearance, smoothness;
  [[nodiscard]] CrfLatticeValues of_size(const DenseCrf& crf, int chunks) {
    const std::size_t floats = static_cast<std::size_t>(chunks) * 8;
    return {appearance.of_size(crf.appearance().vertices() * floats),
            smoothness.of_size(crf.smoothness().vertices() * floats)};
  }
};

/// Parameters filled up to whole vectors, in the order the kernels read them.
struct PaddedParameters {
  int chunks;
  std::vector<float> appearance_weight, smoothness_weight, columns, rows;
  /// Costs that are the same for all classes but one do not change the softmax: where all columns of the compatibility
  /// are constant off the diagonal (Potts, any diagonal matrix), only what the diagonal differs by is left, in the
  /// weights.
  bool own_class_only = true;
  std::vector<float> own_appearance_weight, own_smoothness_weight;

  explicit PaddedParameters(const CrfParameters& p) : chunks((p.classes + 7) / 8) {
    const auto n = static_cast<std::size_t>(p.classes), width = static_cast<std::size_t>(chunks) * 8;
    appearance_weight = p.appearance_weight, smoothness_weight = p.smoothness_weight;
    appearance_weight.resize(width), smoothness_weight.resize(width);
    own_appearance_weight.resize(width), own_smoothness_weight.resize(width);
    columns.resize(n * width), rows.resize(n * width);
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t c = 0; c < n; ++c) columns[c * width + r] = rows[r * width + c] = p.compatibility[r * n + c];
    for (std::size_t c = 0; c < n; ++c) {
      const float* const column = &columns[c * width];
      const float other = n == 1 ? 0.0F : column[c == 0 ? 1 : 0];
      for (std::size_t r = 0; r < n; ++r) own_class_only &= r == c || column[r] == other;
      own_appearance_weight[c] = (other - column[c]) * p.appearance_weight[c];
      own_smoothness_weight[c] = (other - column[c]) * p.smoothness_weight[c];
    }
  }
};

/// Which parameters the forward pass reads: the short form where there is one.
CrfPass forward_pass(const CrfPoints& points, const CrfParameters& parameters, const PaddedParameters& padded,
                     std::size_t values) {
  CrfPass pass{.points = points, .classes = parameters.classes, .values = values};
  const bool own = padded.own_class_only;
  pass.appearance_weight = (own ? padded.own_appearance_weight : padded.appearance_weight).data();
  pass.smoothness_weight = (own ? padded.own_smoothness_weight : padded.smoothness_weight).data();
  pass.compatibility = own ? nullptr : padded.columns.data();
  return pass;
}

template <int D>
void blur(const CrfKernels& kernels, const PermutohedralLattice<D>& lattice, float* values, BlurOrder order) {
  for (int i = 0; i <= D; ++i) {
    const BlurAxis& axis = lattice.axes()[order == BlurOrder::forward ? i : D - i];
    kernels.blur({axis.pairs.data(), axis.pairs.size(), axis.chains.data(), axis.chains.size()}, values);
  }
}

void blur(const CrfKernels& kernels, const DenseCrf& crf, const CrfLatticeValues& values, BlurOrder order) {
  blur(kernels, crf.appearance(), values.appearance, order);
  blur(kernels, crf.smoothness(), values.smoothness, order);
}

/// F with F K F 1 near 1: Kraehenbuehl's symmetric normalisation.
template <int D>
void normalise(PermutohedralLattice<D>& lattice) {
  const std::vector<float> ones(lattice.points().size(), 1.0F);
  std::vector<float> factors = lattice.filter(ones);
  for (float& f : factors) f = 1.0F / std::sqrt(f);
  lattice.scale(factors);
}

}  // namespace

struct CrfWorkspace::Arrays {
  LatticeValues now, next;
};
CrfWorkspace::CrfWorkspace() : arrays_(std::make_unique<Arrays>()) {}
CrfWorkspace::~CrfWorkspace() = default;
CrfWorkspace::CrfWorkspace(CrfWorkspace&&) noexcept = default;
CrfWorkspace& CrfWorkspace::operator=(CrfWorkspace&&) noexcept = default;

CrfParameters potts_crf(int classes, float appearance_weight, float smoothness_weight, int iterations) {
  const auto n = static_cast<std::size_t>(std::max(classes, 0));
  CrfParameters p{.classes = classes, .iterations = iterations};
  p.appearance_weight.assign(n, appearance_weight);
  p.smoothness_weight.assign(n, smoothness_weight);
  p.compatibility.assign(n * n, 1.0F);
  for (std::size_t c = 0; c < n; ++c) p.compatibility[c * n + c] = 0.0F;
  return p;
}

DenseCrf::DenseCrf(const CrfImage& image, const CrfWidths& widths)
    : pixels_(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
  check(widths);
  if (pixels_ > 0xffffffffU / 6) throw OptionError("dense CRF: the image is too large, use windows");
  valid_.reserve(pixels_);
  for (int left = 0; left < image.width; left += strip_px)
    for (int row = 0; row < image.height; ++row)
      for (int col = left; col < std::min(left + strip_px, image.width); ++col) {
        const auto pixel =
            static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(image.width) + static_cast<std::uint32_t>(col);
        (image.valid == nullptr || image.valid[pixel] != 0 ? valid_ : invalid_).push_back(pixel);
      }

  const auto width = static_cast<std::uint32_t>(image.width);
  const double left = static_cast<double>(image.col), right = static_cast<double>(image.col + image.width);
  const double top = static_cast<double>(image.row), bottom = static_cast<double>(image.row + image.height);
  const double plane = 1.0 / widths.theta_alpha_px, colour = 1.0 / widths.theta_beta,
               near = 1.0 / widths.theta_gamma_px;
  appearance_ =
      PermutohedralLattice<5>(valid_.size(),
                              {{left * plane, top * plane, 0.0, 0.0, 0.0},
                               {right * plane, bottom * plane, 255.0 * colour, 255.0 * colour, 255.0 * colour}},
                              [&](std::size_t first, std::size_t count, double* features) {
                                constexpr std::size_t block = PermutohedralLattice<5>::block;
                                for (std::size_t i = 0; i < count; ++i) {
                                  const std::uint32_t pixel = valid_[first + i];
                                  const std::uint8_t* const rgb = image.rgb + std::size_t{3} * pixel;
                                  features[i] = (left + pixel % width) * plane;
                                  const std::uint32_t row = pixel / width;
                                  features[block + i] = (top + row) * plane;
                                  features[2 * block + i] = rgb[0] * colour;
                                  features[3 * block + i] = rgb[1] * colour;
                                  features[4 * block + i] = rgb[2] * colour;
                                }
                              });
  smoothness_ = PermutohedralLattice<2>(valid_.size(), {{left * near, top * near}, {right * near, bottom * near}},
                                        [&](std::size_t first, std::size_t count, double* features) {
                                          constexpr std::size_t block = PermutohedralLattice<2>::block;
                                          for (std::size_t i = 0; i < count; ++i) {
                                            features[i] = (left + valid_[first + i] % width) * near;
                                            const std::uint32_t row = valid_[first + i] / width;
                                            features[block + i] = (top + row) * near;
                                          }
                                        });
  normalise(appearance_);
  normalise(smoothness_);
  CrfReached reached;
  for (std::size_t i = 0; i < valid_.size(); ++i) {
    for (const std::uint32_t v : appearance_.points()[i].vertex)
      reached.appearance = std::max(reached.appearance, v + 1);
    for (const std::uint32_t v : smoothness_.points()[i].vertex)
      reached.smoothness = std::max(reached.smoothness, v + 1);
    if (i % crf_batch == crf_batch - 1 || i + 1 == valid_.size()) reached_.push_back(reached);
  }
}

CrfPoints DenseCrf::valid_points() const {
  return {valid_.size(), valid_.data(), appearance_.points().data(), smoothness_.points().data(), reached_.data()};
}

CrfPoints DenseCrf::invalid_points() const { return {.count = invalid_.size(), .pixel = invalid_.data()}; }

/// `marginals` holds the last step only, or with `tape` every step.
void DenseCrf::run(const CrfParameters& parameters, std::span<const float> unary, std::span<float> marginals, bool tape,
                   CrfWorkspace& workspace) const {
  const PaddedParameters padded(parameters);
  const CrfKernels& kernels = crf_kernels(padded.chunks);
  CrfLatticeValues now = workspace.arrays_->now.of_size(*this, padded.chunks);
  CrfLatticeValues next = workspace.arrays_->next.of_size(*this, padded.chunks);
  for (int step = 0; step <= parameters.iterations; ++step) {
    const bool last = step == parameters.iterations;
    float* const result = tape ? marginals.data() + static_cast<std::size_t>(step) * unary.size() : marginals.data();
    CrfUpdate update{.pass = forward_pass(valid_points(), parameters, padded, unary.size()), .unary = unary.data()};
    if (step > 0) update.in = now;
    if (!last) update.out = next;
    if (tape || last) update.marginals = result;
    kernels.update(update);
    if (tape || last)
      kernels.update({.pass = forward_pass(invalid_points(), parameters, padded, unary.size()),
                      .unary = unary.data(),
                      .marginals = result});
    if (!last) blur(kernels, *this, next, BlurOrder::forward);
    std::swap(now, next);
  }
}

void DenseCrf::infer(const CrfParameters& parameters, std::span<const float> unary, std::span<float> marginals,
                     CrfWorkspace* workspace) const {
  check(parameters);
  assert(unary.size() == pixels_ * static_cast<std::size_t>(parameters.classes) && marginals.size() == unary.size());
  CrfWorkspace own;
  const std::vector<float> potentials =
      parameters.unary_compatibility.empty() ? std::vector<float>{} : unary_potentials(parameters, unary);
  run(parameters, potentials.empty() ? unary : potentials, marginals, false, workspace != nullptr ? *workspace : own);
}

CrfTape DenseCrf::record(const CrfParameters& parameters, std::span<const float> unary) const {
  check(parameters);
  assert(unary.size() == pixels_ * static_cast<std::size_t>(parameters.classes));
  CrfTape tape{.iterations = parameters.iterations, .values = unary.size()};
  tape.marginals.resize(unary.size() * (static_cast<std::size_t>(parameters.iterations) + 1));
  CrfWorkspace workspace;
  if (parameters.unary_compatibility.empty()) {
    run(parameters, unary, tape.marginals, true, workspace);
  } else {
    tape.unary.assign(unary.begin(), unary.end());
    run(parameters, unary_potentials(parameters, unary), tape.marginals, true, workspace);
  }
  return tape;
}

CrfGradients DenseCrf::backward(const CrfParameters& parameters, const CrfTape& tape,
                                std::span<const float> marginals_gradient) const {
  check(parameters);
  const auto classes = static_cast<std::size_t>(parameters.classes);
  const std::size_t values = pixels_ * classes;
  assert(tape.iterations == parameters.iterations && tape.values == values && marginals_gradient.size() == values);
  const PaddedParameters padded(parameters);
  const CrfKernels& kernels = crf_kernels(padded.chunks);
  const std::size_t width = padded.appearance_weight.size();
  std::vector<double> appearance(width), smoothness(width), compatibility(width * classes);
  CrfGradients result;
  result.unary.resize(values);

  CrfBackward step{.pass = {.points = valid_points(),
                            .classes = parameters.classes,
                            .values = values,
                            .appearance_weight = padded.appearance_weight.data(),
                            .smoothness_weight = padded.smoothness_weight.data(),
                            .compatibility_rows = padded.rows.data()},
                   .unary_gradient = result.unary.data(),
                   .appearance_weight_gradient = appearance.data(),
                   .smoothness_weight_gradient = smoothness.data(),
                   .compatibility_gradient = compatibility.data()};
  LatticeValues arrays[3];
  const CrfLatticeValues messages = arrays[0].of_size(*this, padded.chunks);
  CrfLatticeValues now = arrays[1].of_size(*this, padded.chunks), next = arrays[2].of_size(*this, padded.chunks);
  for (int i = parameters.iterations; i >= 0; --i) {
    const bool last = i == parameters.iterations;
    step.marginals = tape.marginals.data() + static_cast<std::size_t>(i) * values;
    step.gradient = last ? marginals_gradient.data() : nullptr;
    step.gradient_in = last ? CrfLatticeValues{} : now;
    step.messages = step.out = {};
    if (i > 0) {  // the messages this step received, once more
      kernels.splat(step.pass, step.marginals - values, messages);
      blur(kernels, *this, messages, BlurOrder::forward);
      step.messages = messages;
      step.out = next;
    }
    kernels.backward(step);
    if (i > 0) blur(kernels, *this, next, BlurOrder::transposed);
    std::swap(now, next);
  }
  // Pixels that take no part: softmax(-unary) only.
  step.pass.points = invalid_points();
  step.marginals = tape.result().data();
  step.gradient = marginals_gradient.data();
  step.messages = {};
  kernels.backward(step);

  result.appearance_weight.assign(appearance.begin(), appearance.begin() + parameters.classes);
  result.smoothness_weight.assign(smoothness.begin(), smoothness.begin() + parameters.classes);
  result.compatibility.resize(classes * classes);
  for (std::size_t r = 0; r < classes; ++r)
    for (std::size_t c = 0; c < classes; ++c)
      result.compatibility[r * classes + c] = static_cast<float>(compatibility[c * width + r]);
  if (!parameters.unary_compatibility.empty()) unary_backward(parameters, tape.unary, result);
  return result;
}

}  // namespace orthodrive
