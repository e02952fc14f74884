// SPDX-License-Identifier: Apache-2.0
#pragma once
// Fully connected conditional random field over the pixels of an image, solved by mean field.
//   k(i, j) = w1 exp(-|p_i - p_j|^2 / 2 theta_alpha^2 - |I_i - I_j|^2 / 2 theta_beta^2) + w2 exp(-|p_i - p_j|^2 / 2
//   theta_gamma^2)
// Kraehenbuehl, Koltun, Efficient Inference in Fully Connected CRFs with Gaussian Edge Potentials, 2012 (the update,
// eq. 2-3); Zheng et al., Conditional Random Fields as Recurrent Neural Networks, 2015 (weights a class, gradients). As
// in the code of both, the kernels are normalised symmetrically (D^-1/2 K D^-1/2, D = diag(K 1)) and a pixel's message
// to itself is kept.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "orthodrive/crf/crf_kernels.hpp"
#include "orthodrive/crf/permutohedral_lattice.hpp"

namespace orthodrive {

/// Widths (standard deviations) of the two Gaussians. The defaults are those of the reference's grid search.
struct CrfWidths {
  double theta_alpha_px = 13.5;  ///< appearance, in the plane
  double theta_beta = 11.0;      ///< appearance, in colour (0-255 per channel)
  double theta_gamma_px = 1.75;  ///< smoothness
};

/// What can be learned.
struct CrfParameters {
  int classes = 0;                       ///< 1 to max_crf_classes
  int iterations = 10;                   ///< 0: the marginals are the softmax of -unary
  std::vector<float> appearance_weight;  ///< w1, one per class
  std::vector<float> smoothness_weight;  ///< w2, one per class
  std::vector<float>
      compatibility;  ///< classes x classes: the cost of row's class at a pixel for a message of column's
  /// classes x classes, M of psi_u(x) = sum_k M[k][x] log p(k) (thesis eq. 2.19: predicted class by row, assigned by
  /// column). Empty: -1 on the diagonal, so that psi_u(x) = -log p(x), which costs no time.
  std::vector<float> unary_compatibility;
};

/// The Potts model: cost 1 for every pair of different classes, the same weights for all classes.
[[nodiscard]] CrfParameters potts_crf(int classes, float appearance_weight, float smoothness_weight,
                                      int iterations = 10);

/// The guiding photo (view). `col`, `row`: place of its first pixel in the mosaic; a window of a mosaic gets the
/// lattice points of the mosaic, so that results agree but for what lies outside the window.
struct CrfImage {
  int width = 0, height = 0;
  std::int64_t col = 0, row = 0;
  const std::uint8_t* rgb = nullptr;  ///< height x width x 3
  const std::uint8_t* valid =
      nullptr;  ///< height x width, 0: the pixel sends and receives nothing; null: all are valid
};

/// A forward run: the marginals before the first iteration and after each.
struct CrfTape {
  int iterations = 0;
  std::size_t values = 0;        ///< pixels x classes
  std::vector<float> marginals;  ///< (iterations + 1) x pixels x classes
  std::vector<float> unary;      ///< as given; kept where there is a unary compatibility
  [[nodiscard]] std::span<const float> result() const { return std::span(marginals).last(values); }
};

/// Derivatives of a loss, laid out as what they belong to.
struct CrfGradients {
  std::vector<float> unary;
  std::vector<float> appearance_weight, smoothness_weight, compatibility;
  std::vector<float> unary_compatibility;  ///< empty where the parameters have none
};

/// Memory of an inference. Given to one after the other on the same thread it saves the system handing out, and
/// zeroing, the pages each time: a tenth of the run time. Holds twice the lattices' vertices x classes, in float.
class CrfWorkspace {
 public:
  CrfWorkspace();
  ~CrfWorkspace();
  CrfWorkspace(CrfWorkspace&&) noexcept;
  CrfWorkspace& operator=(CrfWorkspace&&) noexcept;

 private:
  friend class DenseCrf;
  struct Arrays;
  std::unique_ptr<Arrays> arrays_;
};

/// The image's two lattices, built once; any number of inferences may use them at the same time. One thread works for
/// each call: mosaics run one window a thread.
class DenseCrf {
 public:
  /// The photo is not needed afterwards. Throws OptionError for widths that are not positive or far too small.
  DenseCrf(const CrfImage& image, const CrfWidths& widths);

  /// unary: height x width x classes, -log p, finite. marginals: as many. Classes below 1e-26 of the best come out as
  /// 0.
  void infer(const CrfParameters& parameters, std::span<const float> unary, std::span<float> marginals,
             CrfWorkspace* workspace = nullptr) const;

  /// As infer, keeping what the backward pass needs: iterations + 1 times the size of the unary.
  [[nodiscard]] CrfTape record(const CrfParameters& parameters, std::span<const float> unary) const;
  /// From dL/dmarginals (of the tape's result) to the derivatives by all inputs. Uses the tape only, not the unary.
  [[nodiscard]] CrfGradients backward(const CrfParameters& parameters, const CrfTape& tape,
                                      std::span<const float> marginals_gradient) const;

  /// The pixels that take part and those that do not.
  [[nodiscard]] CrfPoints valid_points() const;
  [[nodiscard]] CrfPoints invalid_points() const;
  [[nodiscard]] const PermutohedralLattice<5>& appearance() const { return appearance_; }
  [[nodiscard]] const PermutohedralLattice<2>& smoothness() const { return smoothness_; }

 private:
  void run(const CrfParameters& parameters, std::span<const float> unary, std::span<float> marginals, bool tape,
           CrfWorkspace& workspace) const;

  std::size_t pixels_ = 0;
  std::vector<std::uint32_t> valid_;    ///< pixel numbers in the order of the lattices' points
  std::vector<std::uint32_t> invalid_;  ///< the others
  PermutohedralLattice<5> appearance_;
  PermutohedralLattice<2> smoothness_;
  std::vector<CrfReached> reached_;
};

}  // namespace orthodrive
