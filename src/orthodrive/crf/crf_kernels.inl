// SPDX-License-Identifier: Apache-2.0
// Included by crf_kernels_*.cpp with ORTHODRIVE_CRF_KERNELS naming the function to define. Everything but that function
// has internal linkage and nothing of the standard library is instantiated here: code for newer processors must not
// leak into the rest of the program.

#include <cstddef>
#include <cstdint>

#include "orthodrive/core/kernel_vectors.inl"
#include "orthodrive/crf/crf_kernels.hpp"

namespace orthodrive {

namespace {

using Vec8 = Lanes<8>::Vector;
using Int8 = std::int32_t __attribute__((vector_size(32)));

ORTHODRIVE_INLINE Vec8 vec8(float x) { return all_lanes<8>(x); }
ORTHODRIVE_INLINE Vec8 load(const float* p) { return load<8>(p); }
ORTHODRIVE_INLINE void store(float* p, Vec8 v) { store<8>(p, v); }
ORTHODRIVE_INLINE Vec8 larger(Vec8 a, Vec8 b) { return a > b ? a : b; }

/// The largest element, in all places.
ORTHODRIVE_INLINE Vec8 largest(Vec8 v) {
  v = larger(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
  v = larger(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
  return larger(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6));
}
ORTHODRIVE_INLINE Vec8 sum(Vec8 v) {
  v += __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3);
  v += __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5);
  return v + __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
}

/// exp(x) for x <= 0, relative error 2e-7 (coefficients of Cephes expf, S. Moshier). 0 below -60, so that products with
/// lattice weights stay far from denormal numbers, which are slow.
ORTHODRIVE_INLINE Vec8 exp_of_negative(Vec8 x) {
  const Vec8 round = vec8(12582912.0F);  // 1.5 * 2^23: the integer is left in the low bits
  const Vec8 clamped = larger(x, vec8(-60.0F));
  const Vec8 shifted = fused(clamped, vec8(1.44269504F), round);
  const Vec8 n = shifted - round;
  const Vec8 r = fused(n, vec8(2.12194440e-4F), fused(-n, vec8(0.693359375F), clamped));
  Vec8 p = vec8(1.9875691500e-4F);
  p = fused(p, r, vec8(1.3981999507e-3F));
  p = fused(p, r, vec8(8.3334519073e-3F));
  p = fused(p, r, vec8(4.1665795894e-2F));
  p = fused(p, r, vec8(1.6666665459e-1F));
  p = fused(p, r, vec8(5.0000001201e-1F));
  p = fused(p * r, r, r) + vec8(1.0F);
  const Int8 power = (reinterpret_cast<Int8>(shifted) - 0x4b400000 + 127) << 23;
  const Int8 keep = x > vec8(-60.0F);
  return reinterpret_cast<Vec8>(reinterpret_cast<Int8>(p * reinterpret_cast<Vec8>(power)) & keep);
}

/// All classes of one pixel.
template <int V>
struct Values {
  Vec8 v[V];
};

/// `classes` values at p, the rest filled with `fill`. `left`: values from p to the end of the array.
template <int V>
ORTHODRIVE_INLINE Values<V> load_classes(const float* p, int classes, std::size_t left, float fill) {
  Values<V> result;
  if (classes == 8 * V) {
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) result.v[k] = load(p + 8 * k);
    return result;
  }
  if (left < 8 * V) {
    float copy[8 * V];
    for (int c = 0; c < 8 * V; ++c) copy[c] = c < classes ? p[c] : fill;
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) result.v[k] = load(copy + 8 * k);
    return result;
  }
  ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) result.v[k] = load(p + 8 * k);
  const Int8 place = Int8{0, 1, 2, 3, 4, 5, 6, 7} + 8 * (V - 1);
  result.v[V - 1] = place < classes ? result.v[V - 1] : vec8(fill);
  return result;
}

template <int V>
ORTHODRIVE_INLINE void store_classes(const Values<V>& values, float* p, int classes) {
  ORTHODRIVE_UNROLL for (int k = 0; k < V - 1; ++k) store(p + 8 * k, values.v[k]);
  if (classes == 8 * V) return store(p + 8 * (V - 1), values.v[V - 1]);
  float copy[8];
  store(copy, values.v[V - 1]);
  for (int c = 8 * (V - 1); c < classes; ++c) p[c] = copy[c - 8 * (V - 1)];
}

template <int V, int D>
ORTHODRIVE_INLINE Values<V> slice(const LatticePoint<D>& point, const float* lattice) {
  Values<V> result{};
  ORTHODRIVE_UNROLL for (int i = 0; i <= D; ++i) {
    const auto* vertex = reinterpret_cast<const Vec8*>(lattice) + std::size_t{point.vertex[i]} * V;
    const Vec8 weight = vec8(point.weight[i]);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) result.v[k] = fused(weight, vertex[k], result.v[k]);
  }
  return result;
}

template <int V, int D>
ORTHODRIVE_INLINE void splat(const Values<V>& values, const LatticePoint<D>& point, float* lattice) {
  ORTHODRIVE_UNROLL for (int i = 0; i <= D; ++i) {
    auto* vertex = reinterpret_cast<Vec8*>(lattice) + std::size_t{point.vertex[i]} * V;
    const Vec8 weight = vec8(point.weight[i]);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) vertex[k] = fused(weight, values.v[k], vertex[k]);
  }
}

/// target -= matrix * values; matrix is `classes` columns of 8 V.
template <int V>
ORTHODRIVE_INLINE void subtract_product(Values<V>& target, const float* matrix, const Values<V>& values, int classes) {
  alignas(32) float factor[8 * V];
  ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) store(factor + 8 * k, values.v[k]);
  for (int c = 0; c < classes; ++c) {
    const Vec8 f = vec8(factor[c]);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) target.v[k] =
        fused(-f, load(matrix + 8 * V * c + 8 * k), target.v[k]);
  }
}

constexpr float no_class = 1e30F;  // -log p of the classes that only fill up the last vector

/// Sets to zero the vertices that batch b is the first to meet.
template <int V>
ORTHODRIVE_INLINE void clear_new_vertices(const CrfPoints& points, std::size_t b, const CrfLatticeValues& out) {
  const CrfReached from = b > 0 ? points.reached[b - 1] : CrfReached{}, to = points.reached[b];
  auto* const appearance = reinterpret_cast<Vec8*>(out.appearance);
  auto* const smoothness = reinterpret_cast<Vec8*>(out.smoothness);
  for (std::size_t i = std::size_t{from.appearance} * V; i < std::size_t{to.appearance} * V; ++i)
    appearance[i] = Vec8{};
  for (std::size_t i = std::size_t{from.smoothness} * V; i < std::size_t{to.smoothness} * V; ++i)
    smoothness[i] = Vec8{};
}

/// Asks for the cache lines of a point's vertices.
template <int V, int D>
ORTHODRIVE_INLINE void prefetch(const LatticePoint<D>& point, const float* lattice) {
  ORTHODRIVE_UNROLL for (int i = 0; i <= D; ++i) {
    const float* const vertex = lattice + std::size_t{point.vertex[i]} * (8 * V);
    ORTHODRIVE_UNROLL for (int k = 0; k < 8 * V; k += 16) __builtin_prefetch(vertex + k, 1);
  }
}

// The pixels of a batch go through each phase together, so that the processor always has independent work at hand: a
// single pixel is one long chain of sums, maximum, exp, sum, division.
constexpr std::size_t batch = crf_batch;

template <int V>
ORTHODRIVE_INLINE void collect_scores(const CrfUpdate& u, std::size_t first, std::size_t count, Values<V>* scores) {
  const CrfPass& pass = u.pass;
  const CrfPoints& points = pass.points;
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t i = first + j;
    const std::size_t at = std::size_t{points.pixel[i]} * static_cast<std::size_t>(pass.classes);
    if (u.out.appearance != nullptr) {
      prefetch<V>(points.appearance[i], u.out.appearance);
      prefetch<V>(points.smoothness[i], u.out.smoothness);
    }
    Values<V> score = load_classes<V>(u.unary + at, pass.classes, pass.values - at, no_class);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) score.v[k] = -score.v[k];
    if (u.in.appearance != nullptr) {
      Values<V> message = slice<V>(points.appearance[i], u.in.appearance);
      const Values<V> smooth = slice<V>(points.smoothness[i], u.in.smoothness);
      ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) message.v[k] =
          fused(load(pass.smoothness_weight + 8 * k), smooth.v[k], load(pass.appearance_weight + 8 * k) * message.v[k]);
      if (pass.compatibility != nullptr) {
        subtract_product(score, pass.compatibility, message, pass.classes);
      } else {
        ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) score.v[k] += message.v[k];
      }
    }
    scores[j] = score;
  }
}

/// Scores to probabilities.
template <int V>
ORTHODRIVE_INLINE void softmax(std::size_t count, Values<V>* scores) {
  for (std::size_t j = 0; j < count; ++j) {
    Vec8 top = scores[j].v[0];
    ORTHODRIVE_UNROLL for (int k = 1; k < V; ++k) top = larger(top, scores[j].v[k]);
    top = largest(top);
    Vec8 total{};
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) total += scores[j].v[k] = exp_of_negative(scores[j].v[k] - top);
    const Vec8 scale = vec8(1.0F) / sum(total);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) scores[j].v[k] *= scale;
  }
}

template <int V>
void update(const CrfUpdate& u) {
  const CrfPoints& points = u.pass.points;
  Values<V> values[batch];
  for (std::size_t first = 0; first < points.count; first += batch) {
    const std::size_t count = points.count - first < batch ? points.count - first : batch;
    for (std::size_t j = first + batch; j < first + 2 * batch && j < points.count; ++j) {
      const float* const ahead = u.unary + std::size_t{points.pixel[j]} * static_cast<std::size_t>(u.pass.classes);
      ORTHODRIVE_UNROLL for (int k = 0; k < 8 * V; k += 16) __builtin_prefetch(ahead + k);
      if (u.in.appearance != nullptr) {
        prefetch<V>(points.appearance[j], u.in.appearance);
        prefetch<V>(points.smoothness[j], u.in.smoothness);
      }
    }
    collect_scores<V>(u, first, count, values);
    softmax<V>(count, values);
    if (u.out.appearance != nullptr) {
      clear_new_vertices<V>(points, first / batch, u.out);
      for (std::size_t j = 0; j < count; ++j) {
        splat(values[j], points.appearance[first + j], u.out.appearance);
        splat(values[j], points.smoothness[first + j], u.out.smoothness);
      }
    }
    if (u.marginals != nullptr)
      for (std::size_t j = 0; j < count; ++j)
        store_classes(values[j],
                      u.marginals + std::size_t{points.pixel[first + j]} * static_cast<std::size_t>(u.pass.classes),
                      u.pass.classes);
  }
}

template <int V>
void splat_marginals(const CrfPass& pass, const float* marginals, const CrfLatticeValues& out) {
  const CrfPoints& points = pass.points;
  for (std::size_t i = 0; i < points.count; ++i) {
    if (i % batch == 0) clear_new_vertices<V>(points, i / batch, out);
    const std::size_t at = std::size_t{points.pixel[i]} * static_cast<std::size_t>(pass.classes);
    const Values<V> q = load_classes<V>(marginals + at, pass.classes, pass.values - at, 0.0F);
    splat(q, points.appearance[i], out.appearance);
    splat(q, points.smoothness[i], out.smoothness);
  }
}

/// Sums over pixels, in float over short runs and in double over all.
template <int V>
struct ParameterSums {
  alignas(32) float appearance[8 * V] = {}, smoothness[8 * V] = {}, compatibility[64 * V * V] = {};
};

template <int V>
void flush(ParameterSums<V>& sums, const CrfBackward& b) {
  for (int c = 0; c < 8 * V; ++c) b.appearance_weight_gradient[c] += static_cast<double>(sums.appearance[c]);
  for (int c = 0; c < 8 * V; ++c) b.smoothness_weight_gradient[c] += static_cast<double>(sums.smoothness[c]);
  for (int c = 0; c < 8 * V * b.pass.classes; ++c)
    b.compatibility_gradient[c] += static_cast<double>(sums.compatibility[c]);
  sums = {};
}

template <int V>
void backward(const CrfBackward& b) {
  const CrfPass& pass = b.pass;
  const CrfPoints& points = pass.points;
  ParameterSums<V> sums;
  for (std::size_t i = 0; i < points.count; ++i) {
    const std::size_t at = std::size_t{points.pixel[i]} * static_cast<std::size_t>(pass.classes);
    const std::size_t left = pass.values - at;
    const Values<V> q = load_classes<V>(b.marginals + at, pass.classes, left, 0.0F);
    Values<V> g;
    if (b.gradient != nullptr) {
      g = load_classes<V>(b.gradient + at, pass.classes, left, 0.0F);
    } else {
      g = slice<V>(points.appearance[i], b.gradient_in.appearance);
      const Values<V> smooth = slice<V>(points.smoothness[i], b.gradient_in.smoothness);
      ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) g.v[k] += smooth.v[k];
    }
    Vec8 mean{};  // dL/dscores = Q (G - sum Q G)
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) mean = fused(q.v[k], g.v[k], mean);
    mean = sum(mean);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) g.v[k] = q.v[k] * (g.v[k] - mean);
    Values<V> unary = load_classes<V>(b.unary_gradient + at, pass.classes, left, 0.0F);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) unary.v[k] -= g.v[k];
    store_classes(unary, b.unary_gradient + at, pass.classes);
    if (b.messages.appearance == nullptr) continue;

    Values<V> appearance = slice<V>(points.appearance[i], b.messages.appearance);
    Values<V> smoothness = slice<V>(points.smoothness[i], b.messages.smoothness);
    alignas(32) float message[8 * V];
    Values<V> h{};
    subtract_product(h, pass.compatibility_rows, g, pass.classes);
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) {
      const Vec8 w1 = load(pass.appearance_weight + 8 * k), w2 = load(pass.smoothness_weight + 8 * k);
      store(message + 8 * k, fused(w2, smoothness.v[k], w1 * appearance.v[k]));
      store(sums.appearance + 8 * k, fused(h.v[k], appearance.v[k], load(sums.appearance + 8 * k)));
      store(sums.smoothness + 8 * k, fused(h.v[k], smoothness.v[k], load(sums.smoothness + 8 * k)));
      appearance.v[k] = w1 * h.v[k];
      smoothness.v[k] = w2 * h.v[k];
    }
    for (int c = 0; c < pass.classes; ++c) {
      float* column = sums.compatibility + 8 * V * c;
      const Vec8 m = vec8(message[c]);
      ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) store(column + 8 * k, fused(-m, g.v[k], load(column + 8 * k)));
    }
    if (i % batch == 0) clear_new_vertices<V>(points, i / batch, b.out);
    splat(appearance, points.appearance[i], b.out.appearance);
    splat(smoothness, points.smoothness[i], b.out.smoothness);
    if (i % 64 == 63) flush(sums, b);
  }
  flush(sums, b);
}

template <int V>
void blur(const CrfBlurRows& rows, float* values) {
  auto* const lattice = reinterpret_cast<Vec8*>(values);
  const Vec8 half = vec8(0.5F);
  for (std::size_t i = 0; i < rows.pair_values; i += 2) {
    Vec8* const a = lattice + std::size_t{rows.pairs[i]} * V;
    Vec8* const b = lattice + std::size_t{rows.pairs[i + 1]} * V;
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) {
      const Vec8 old_a = a[k], old_b = b[k];
      a[k] = old_a + half * old_b;
      b[k] = old_b + half * old_a;
    }
  }
  const std::uint32_t *chain = rows.chains, *const end = chain + rows.chain_values;
  while (chain != end) {
    const std::uint32_t length = *chain++;
    Vec8* vertex = lattice + std::size_t{*chain} * V;
    Values<V> previous{}, current;
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) current.v[k] = vertex[k];
    for (std::uint32_t i = 1; i < length; ++i) {
      Vec8* const next = lattice + std::size_t{chain[i]} * V;
      ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) {
        const Vec8 value = next[k];
        vertex[k] = current.v[k] + half * (previous.v[k] + value);
        previous.v[k] = current.v[k];
        current.v[k] = value;
      }
      vertex = next;
    }
    ORTHODRIVE_UNROLL for (int k = 0; k < V; ++k) vertex[k] = current.v[k] + half * previous.v[k];
    chain += length;
  }
}

template <int V>
constexpr CrfKernels kernels_of = {update<V>, splat_marginals<V>, backward<V>, blur<V>};

constexpr CrfKernels all_kernels[] = {kernels_of<1>, kernels_of<2>, kernels_of<3>, kernels_of<4>,
                                      kernels_of<5>, kernels_of<6>, kernels_of<7>, kernels_of<8>};

}  // namespace

const CrfKernels* ORTHODRIVE_CRF_KERNELS() { return all_kernels; }

}  // namespace orthodrive
