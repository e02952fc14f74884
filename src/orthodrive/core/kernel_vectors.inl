// SPDX-License-Identifier: Apache-2.0
// Vectors of floats for the files that are compiled once per family of processors (kernel_family.hpp). Everything has
// internal linkage and nothing of the standard library is instantiated here: code for newer processors must not leak
// into the rest of the program.

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace orthodrive {
namespace {

#define ORTHODRIVE_INLINE [[gnu::always_inline]] inline
#if defined(__clang__)
#define ORTHODRIVE_UNROLL _Pragma("clang loop unroll(full)")
#else
#define ORTHODRIVE_UNROLL _Pragma("GCC unroll 16")
#endif

/// L floats; loads and stores need no alignment.
template <int L>
struct Lanes;
template <>
struct Lanes<8> {
  using Vector = float __attribute__((vector_size(32), may_alias));
  using Unaligned [[gnu::aligned(4), gnu::may_alias]] = float __attribute__((vector_size(32)));
};
template <>
struct Lanes<16> {
  using Vector = float __attribute__((vector_size(64), may_alias));
  using Unaligned [[gnu::aligned(4), gnu::may_alias]] = float __attribute__((vector_size(64)));
};

template <int L>
ORTHODRIVE_INLINE typename Lanes<L>::Vector load(const float* p) {
  return *reinterpret_cast<const typename Lanes<L>::Unaligned*>(p);
}
template <int L>
ORTHODRIVE_INLINE void store(float* p, typename Lanes<L>::Vector v) {
  *reinterpret_cast<typename Lanes<L>::Unaligned*>(p) = v;
}
template <int L>
ORTHODRIVE_INLINE typename Lanes<L>::Vector all_lanes(float x) {
  return x - typename Lanes<L>::Vector{};
}

/// a * b + c with one rounding: the same bits on every processor.
ORTHODRIVE_INLINE Lanes<8>::Vector fused(Lanes<8>::Vector a, Lanes<8>::Vector b, Lanes<8>::Vector c) {
#if defined(__AVX2__)
  return _mm256_fmadd_ps(a, b, c);
#elif defined(__aarch64__)
  const auto half = [](const Lanes<8>::Vector& v, int first) {
    return vld1q_f32(reinterpret_cast<const float*>(&v) + first);
  };
  Lanes<8>::Vector result;
  for (int first = 0; first < 8; first += 4)
    vst1q_f32(reinterpret_cast<float*>(&result) + first, vfmaq_f32(half(c, first), half(a, first), half(b, first)));
  return result;
#else
  ORTHODRIVE_UNROLL for (int i = 0; i < 8; ++i) c[i] = __builtin_fmaf(a[i], b[i], c[i]);
  return c;
#endif
}
#if defined(__AVX512F__)
ORTHODRIVE_INLINE Lanes<16>::Vector fused(Lanes<16>::Vector a, Lanes<16>::Vector b, Lanes<16>::Vector c) {
  return _mm512_fmadd_ps(a, b, c);
}
#endif

}  // namespace
}  // namespace orthodrive
