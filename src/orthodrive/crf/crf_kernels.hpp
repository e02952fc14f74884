// SPDX-License-Identifier: Apache-2.0
#pragma once
// The inner loops of the dense CRF, compiled once per processor family (crf_kernels_*.cpp) and chosen at run time.
// Values of all classes of a pixel or lattice vertex lie side by side, filled up to `chunks` vectors of eight floats.

#include <cstddef>
#include <cstdint>

#include "orthodrive/core/kernel_family.hpp"
#include "orthodrive/crf/permutohedral_lattice.hpp"

namespace orthodrive {

constexpr int max_crf_classes = 64;
constexpr std::size_t crf_batch = 16;  ///< so many pixels go through each phase of a pass together

/// How many vertices have been met when a batch of pixels is done: they are numbered as they are met, so the new ones
/// are set to zero just before the batch adds to them, when they are about to be in the cache anyway.
struct CrfReached {
  std::uint32_t appearance = 0, smoothness = 0;
};

/// The pixels that take part, in an order that keeps neighbours together, and where they lie in both lattices.
/// Barycentric weights include the symmetric normalisation.
struct CrfPoints {
  std::size_t count = 0;
  const std::uint32_t* pixel = nullptr;
  const LatticePoint<5>* appearance = nullptr;
  const LatticePoint<2>* smoothness = nullptr;
  const CrfReached* reached = nullptr;  ///< one a batch
};

/// One array a lattice: vertices x 8 chunks, 32-byte aligned. Null: none. What is splatted to need not be initialised.
struct CrfLatticeValues {
  float* appearance = nullptr;
  float* smoothness = nullptr;
};

/// What all passes share. Tables are filled up with zeros to 8 chunks.
struct CrfPass {
  CrfPoints points;
  int classes = 0;
  std::size_t values = 0;                     ///< pixels x classes
  const float* appearance_weight = nullptr;   ///< w1; with compatibility null: what to add to the scores instead
  const float* smoothness_weight = nullptr;   ///< w2, likewise
  const float* compatibility = nullptr;       ///< column by column, or null: messages go to their own class only
  const float* compatibility_rows = nullptr;  ///< row by row, for the backward pass
};

/// One mean-field step: Q = softmax(-unary - compatibility (w1 K1 Q' + w2 K2 Q')), with K Q' sliced from `in` (null: no
/// messages), Q splatted to `out` (null: not) and stored in `marginals` (null: not).
struct CrfUpdate {
  CrfPass pass;
  const float* unary = nullptr;
  CrfLatticeValues in, out;
  float* marginals = nullptr;
};

/// One step of back-propagation. G = dL/dQ comes from `gradient`, or is sliced from `gradient_in`. Adds dL/dunary; if
/// there are messages adds the derivatives by the parameters, and splats w1 h and w2 h, h = dL/d(w1 K1 Q' + w2 K2 Q').
struct CrfBackward {
  CrfPass pass;
  const float* marginals = nullptr;  ///< Q of this step
  const float* gradient = nullptr;
  CrfLatticeValues gradient_in, messages, out;
  float* unary_gradient = nullptr;
  double* appearance_weight_gradient = nullptr;  ///< 8 chunks
  double* smoothness_weight_gradient = nullptr;
  double* compatibility_gradient = nullptr;  ///< classes columns of 8 chunks
};

/// A BlurAxis without its vectors.
struct CrfBlurRows {
  const std::uint32_t* pairs = nullptr;
  std::size_t pair_values = 0;
  const std::uint32_t* chains = nullptr;
  std::size_t chain_values = 0;
};

struct CrfKernels {
  void (*update)(const CrfUpdate&);
  void (*splat)(const CrfPass&, const float* marginals, const CrfLatticeValues& out);
  void (*backward)(const CrfBackward&);
  void (*blur)(const CrfBlurRows&, float* values);
};

/// Those of a family that this processor can run, for `chunks` = ceil(classes / 8), at most max_crf_classes / 8.
[[nodiscard]] const CrfKernels& crf_kernels(int chunks, KernelFamily family = kernel_family());

// Tables by chunks - 1.
[[nodiscard]] const CrfKernels* plain_crf_kernels();
[[nodiscard]] const CrfKernels* avx2_crf_kernels();
[[nodiscard]] const CrfKernels* avx512_crf_kernels();

}  // namespace orthodrive
