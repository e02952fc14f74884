// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/dense_crf.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "crf/scalar_crf.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"

namespace orthodrive {
namespace {

const CrfWidths thesis{13.5, 11.0, 1.75};
const CrfWidths original{80.0, 13.0, 3.0};  // Kraehenbuehl & Koltun's example

std::vector<float> infer(const DenseCrf& crf, const CrfParameters& parameters, const std::vector<float>& unary) {
  std::vector<float> marginals(unary.size(), -1.0F);
  crf.infer(parameters, unary, marginals);
  return marginals;
}

/// Weights and a compatibility without any symmetry.
CrfParameters uneven_parameters(int classes, std::uint64_t seed, int iterations) {
  Random random(seed);
  CrfParameters p = potts_crf(classes, 3.0F, 1.5F, iterations);
  for (float& w : p.appearance_weight) w *= static_cast<float>(random.uniform(0.5, 1.5));
  for (float& w : p.smoothness_weight) w *= static_cast<float>(random.uniform(0.5, 1.5));
  for (float& c : p.compatibility) c += static_cast<float>(0.3 * random.normal());
  return p;
}

double largest_difference(const std::vector<float>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(static_cast<double>(a[i]) - b[i]));
  return largest;
}

void punch_holes(TestPhoto& photo) {
  photo.valid.assign(photo.pixels(), 1);
  for (int y = 5; y < 12; ++y)
    for (int x = 0; x < 9; ++x) photo.valid[static_cast<std::size_t>(y * photo.width + x)] = 0;
  photo.valid.back() = 0;
}

struct ScalarCase {
  int classes;
  CrfWidths widths;
  bool uneven, holes;
};

class DenseCrfAgainstScalar : public testing::TestWithParam<ScalarCase> {};

TEST_P(DenseCrfAgainstScalar, marginals_are_equal) {
  const auto& [classes, widths, uneven, holes] = GetParam();
  TestPhoto photo = make_photo(45, 37, classes, 11);
  if (holes) punch_holes(photo);
  const auto unary = make_unary(photo, classes, 12);
  const auto parameters = uneven ? uneven_parameters(classes, 13, 10) : potts_crf(classes, 5.2F, 1.5F);
  const auto fast = infer(DenseCrf(photo.view(), widths), parameters, unary);
  const auto slow = ScalarCrf(photo, widths, false).infer(parameters, {unary.begin(), unary.end()});
  const double difference = largest_difference(fast, slow);
  EXPECT_LT(difference, 1e-4);  // the number asked for
  RecordProperty("difference_e9", static_cast<int>(1e9 * difference));
  std::vector<double> softmax_only =
      ScalarCrf(photo, widths, false).infer(potts_crf(classes, 0, 0, 0), {unary.begin(), unary.end()});
  EXPECT_TRUE(classes == 1 || largest_difference(fast, softmax_only) > 0.3);  // the CRF does something here
}

INSTANTIATE_TEST_SUITE_P(cases, DenseCrfAgainstScalar,
                         testing::Values(ScalarCase{8, thesis, false, false}, ScalarCase{8, original, true, false},
                                         ScalarCase{5, thesis, true, true}, ScalarCase{13, original, false, true},
                                         ScalarCase{1, thesis, false, false}, ScalarCase{2, thesis, true, false},
                                         ScalarCase{38, thesis, true, false}));

// The permutohedral lattice only approximates the Gaussian: so much is lost against the O(n^2) sum.
TEST(DenseCrf, agrees_with_brute_force) {
  struct Case {
    CrfWidths widths;
    float w1, w2;
    int classes;
  };
  for (const Case& c : {Case{thesis, 5.2F, 1.5F, 6}, Case{original, 10.0F, 3.0F, 6},
                        Case{{13.5, 11.0, 3.0}, 3.0F, 3.0F, 8}, Case{{160.0, 3.0, 3.0}, 5.0F, 3.0F, 4}}) {
    std::size_t equal = 0, pixels = 0;
    double sum = 0.0;
    for (const std::uint64_t seed : {21, 22}) {
      const TestPhoto photo = make_photo(32, 28, c.classes, seed);
      const auto unary = make_unary(photo, c.classes, seed + 100);
      const auto parameters = potts_crf(c.classes, c.w1, c.w2);
      const auto fast = infer(DenseCrf(photo.view(), c.widths), parameters, unary);
      const auto exact = ScalarCrf(photo, c.widths, true).infer(parameters, {unary.begin(), unary.end()});
      const auto n = static_cast<std::size_t>(c.classes);
      for (std::size_t i = 0; i < photo.pixels(); ++i) {
        equal += std::max_element(&fast[i * n], &fast[i * n] + n) - &fast[i * n] ==
                 std::max_element(&exact[i * n], &exact[i * n] + n) - &exact[i * n];
        for (std::size_t k = 0; k < n; ++k) sum += std::abs(static_cast<double>(fast[i * n + k]) - exact[i * n + k]);
      }
      pixels += photo.pixels();
    }
    const double agreement = static_cast<double>(equal) / static_cast<double>(pixels);
    const double mean = sum / static_cast<double>(pixels * static_cast<std::size_t>(c.classes));
    std::printf("theta %.4g %.4g %.4g: equal %.4f, mean difference %.5f\n", c.widths.theta_alpha_px,
                c.widths.theta_beta, c.widths.theta_gamma_px, agreement, mean);
    EXPECT_GE(agreement, 0.995);
    EXPECT_LE(mean, 0.01);
  }
}

// A window of a mosaic has the lattice of the mosaic: only what lies outside is missing.
TEST(DenseCrf, inner_part_of_a_window_equals_the_whole_image) {
  const int size = 200, left = 57, top = 43, side = 120, margin = 50, classes = 5;
  const std::int64_t col = 70001, row = 123457;  // of the whole image in a large mosaic
  const TestPhoto photo = make_photo(size, size, classes, 31);
  const auto unary = make_unary(photo, classes, 32);
  TestPhoto window{.width = side, .height = side};
  std::vector<float> window_unary;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto from = static_cast<std::size_t>((top + y) * size + left + x);
      window.rgb.insert(window.rgb.end(), &photo.rgb[3 * from], &photo.rgb[3 * from] + 3);
      window_unary.insert(window_unary.end(), &unary[from * classes], &unary[from * classes] + classes);
    }
  window.labels.resize(static_cast<std::size_t>(side * side));
  const CrfWidths widths{6.0, 30.0, 1.75};
  const auto parameters = potts_crf(classes, 2.0F, 1.0F, 2);
  const auto whole = infer(DenseCrf(photo.view(col, row), widths), parameters, unary);
  const auto largest = [&](std::int64_t window_col) {
    const auto part = infer(DenseCrf(window.view(window_col, row + top), widths), parameters, window_unary);
    double difference = 0.0;
    for (int y = margin; y < side - margin; ++y)
      for (int x = margin; x < side - margin; ++x)
        for (int c = 0; c < classes; ++c)
          difference = std::max(
              difference, std::abs(static_cast<double>(
                                       whole[static_cast<std::size_t>(((top + y) * size + left + x) * classes + c)]) -
                                   static_cast<double>(part[static_cast<std::size_t>((y * side + x) * classes + c)])));
    return difference;
  };
  const double same = largest(col + left), own = largest(0);
  std::printf("window against whole image: %.2e; with a lattice of its own %.2e\n", same, own);
  EXPECT_LT(same, 1e-5);
  EXPECT_GT(own, 1e-3);
}

TEST(DenseCrf, invalid_pixels_send_and_receive_nothing) {
  TestPhoto photo = make_photo(30, 25, 4, 41);
  punch_holes(photo);
  auto unary = make_unary(photo, 4, 42);
  const auto parameters = potts_crf(4, 5.2F, 1.5F);
  const auto before = infer(DenseCrf(photo.view(), thesis), parameters, unary);
  Random random(43);
  for (std::size_t i = 0; i < photo.pixels(); ++i) {
    if (photo.valid[i] != 0) continue;
    for (int k = 0; k < 3; ++k)
      photo.rgb[3 * i + static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(random.below(256));
    for (std::size_t c = 0; c < 4; ++c) unary[4 * i + c] = static_cast<float>(random.uniform(0.0, 5.0));
  }
  const auto after = infer(DenseCrf(photo.view(), thesis), parameters, unary);
  for (std::size_t i = 0; i < photo.pixels(); ++i) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 4; ++c) sum += std::exp(-static_cast<double>(unary[4 * i + c]));
    for (std::size_t c = 0; c < 4; ++c)
      if (photo.valid[i] != 0)
        EXPECT_EQ(before[4 * i + c], after[4 * i + c]);
      else
        EXPECT_NEAR(after[4 * i + c], std::exp(-static_cast<double>(unary[4 * i + c])) / sum, 1e-6);
  }
}

TEST(DenseCrf, nothing_valid_and_no_pixel_at_all) {
  TestPhoto photo = make_photo(6, 5, 3, 51);
  photo.valid.assign(photo.pixels(), 0);
  const auto unary = make_unary(photo, 3, 52);
  const auto parameters = potts_crf(3, 5.2F, 1.5F);
  const auto none = infer(DenseCrf(photo.view(), thesis), parameters, unary);
  EXPECT_EQ(none, infer(DenseCrf(photo.view(), thesis), potts_crf(3, 0.0F, 0.0F, 0), unary));
  const DenseCrf crf(photo.view(), thesis);
  const CrfTape tape = crf.record(parameters, unary);
  EXPECT_EQ(crf.backward(parameters, tape, std::vector<float>(unary.size(), 1.0F)).unary.size(), unary.size());
  EXPECT_TRUE(infer(DenseCrf(CrfImage{}, thesis), parameters, {}).empty());
}

TEST(DenseCrf, certain_and_impossible_classes) {
  const TestPhoto photo = make_photo(20, 20, 3, 61);
  std::vector<float> unary(photo.pixels() * 3, 200.0F);  // -log p of classes ruled out
  for (std::size_t i = 0; i < photo.pixels(); ++i) unary[3 * i + 1] = 0.0F;
  const auto marginals = infer(DenseCrf(photo.view(), thesis), potts_crf(3, 5.2F, 1.5F), unary);
  for (std::size_t i = 0; i < photo.pixels(); ++i) {
    EXPECT_EQ(marginals[3 * i + 1], 1.0F);
    EXPECT_EQ(marginals[3 * i], 0.0F);
  }
}

TEST(DenseCrf, a_diagonal_compatibility_is_the_potts_model) {
  const TestPhoto photo = make_photo(25, 20, 6, 71);
  const auto unary = make_unary(photo, 6, 72);
  const CrfParameters potts = potts_crf(6, 5.2F, 1.5F);
  CrfParameters diagonal = potts, nearly = potts;
  for (float& c : diagonal.compatibility) c -= 1.0F;
  nearly.compatibility[1] += 1e-6F;  // takes the long way, through the full matrix
  const DenseCrf crf(photo.view(), thesis);
  const auto expected = infer(crf, potts, unary);
  EXPECT_EQ(infer(crf, diagonal, unary), expected);
  const auto full = infer(crf, nearly, unary);
  EXPECT_LT(largest_difference(full, {expected.begin(), expected.end()}), 2e-5);
}

/// M of the thesis' eq. 2.19 with -1 on its diagonal.
std::vector<float> minus_identity(std::size_t n) {
  std::vector<float> matrix(n * n, 0.0F);
  for (std::size_t c = 0; c < n; ++c) matrix[c * n + c] = -1.0F;
  return matrix;
}

TEST(DenseCrf, unary_compatibility_begins_as_none_and_can_rename_classes) {
  const TestPhoto photo = make_photo(25, 20, 4, 91);
  const auto unary = make_unary(photo, 4, 92);
  const DenseCrf crf(photo.view(), thesis);
  CrfParameters parameters = potts_crf(4, 5.2F, 1.5F);
  const auto expected = infer(crf, parameters, unary);
  parameters.unary_compatibility = minus_identity(4);
  EXPECT_EQ(infer(crf, parameters, unary), expected);
  parameters.unary_compatibility.assign(16, 0.0F);
  for (std::size_t k = 0; k < 4; ++k) parameters.unary_compatibility[k * 4 + (k + 1) % 4] = -1.0F;
  const auto renamed = infer(crf, parameters, unary);
  for (std::size_t i = 0; i < photo.pixels(); ++i)
    for (std::size_t k = 0; k < 4; ++k) ASSERT_EQ(renamed[4 * i + (k + 1) % 4], expected[4 * i + k]);
  parameters.unary_compatibility.pop_back();
  EXPECT_THROW((void)infer(crf, parameters, unary), OptionError);
}

TEST(DenseCrf, gradients_of_the_unary_compatibility_equal_central_differences) {
  constexpr int classes = 4;
  TestPhoto photo = make_photo(14, 13, classes, 93);
  punch_holes(photo);
  const auto unary = make_unary(photo, classes, 94);
  const CrfWidths widths{6.0, 40.0, 1.75};
  CrfParameters parameters = uneven_parameters(classes, 95, 4);
  parameters.unary_compatibility = minus_identity(classes);
  Random random(96);
  for (float& m : parameters.unary_compatibility) m += static_cast<float>(0.2 * random.normal());
  std::vector<float> a(unary.size());
  for (float& x : a) x = static_cast<float>(random.normal());
  const DenseCrf crf(photo.view(), widths);
  const CrfGradients gradients = crf.backward(parameters, crf.record(parameters, unary), a);
  const ScalarCrf scalar(photo, widths, false);
  const auto loss = [&](const std::vector<float>& m, const std::vector<double>& u) {
    std::vector<double> potentials(u.size(), 0.0);
    for (std::size_t i = 0; i < u.size(); i += classes)
      for (std::size_t k = 0; k < classes; ++k)
        for (std::size_t x = 0; x < classes; ++x)
          potentials[i + x] -= static_cast<double>(m[k * classes + x]) * u[i + k];
    const auto q = scalar.infer(parameters, potentials);
    return std::inner_product(q.begin(), q.end(), a.begin(), 0.0);
  };
  const std::vector<double> exact(unary.begin(), unary.end());
  ASSERT_EQ(gradients.unary_compatibility.size(), 16U);
  for (std::size_t i = 0; i < 16; ++i) {
    auto high = parameters.unary_compatibility, low = high;
    high[i] += 0x1p-11F, low[i] -= 0x1p-11F;
    const double numeric =
        (loss(high, exact) - loss(low, exact)) / (static_cast<double>(high[i]) - static_cast<double>(low[i]));
    EXPECT_NEAR(gradients.unary_compatibility[i], numeric, 1e-3 * (0.05 + std::abs(numeric))) << i;
  }
  for (std::size_t i = 0; i < unary.size(); i += 37) {
    auto high = exact, low = exact;
    high[i] += 1e-4, low[i] -= 1e-4;
    const double numeric =
        (loss(parameters.unary_compatibility, high) - loss(parameters.unary_compatibility, low)) / 2e-4;
    EXPECT_NEAR(gradients.unary[i], numeric, 1e-3 * (0.05 + std::abs(numeric))) << i;
  }
}

/// Derivatives of L = sum of a Q by central differences of the scalar CRF in double: exact to 1e-8.
TEST(DenseCrf, gradients_equal_central_differences) {
  struct Case {
    int classes, iterations;
    bool holes;
  };
  for (const auto& [classes, iterations, holes] : {Case{3, 5, false}, Case{10, 3, true}}) {
    TestPhoto photo = make_photo(14, 13, classes, 81);
    if (holes) punch_holes(photo);
    const auto unary = make_unary(photo, classes, 82);
    const CrfWidths widths{6.0, 40.0, 1.75};
    const CrfParameters parameters = uneven_parameters(classes, 83, iterations);
    Random random(84);
    std::vector<float> a(unary.size());
    for (float& x : a) x = static_cast<float>(random.normal());
    const DenseCrf crf(photo.view(), widths);
    const CrfTape tape = crf.record(parameters, unary);
    const CrfGradients gradients = crf.backward(parameters, tape, a);

    const ScalarCrf scalar(photo, widths, false);
    const auto loss = [&](const CrfParameters& p, const std::vector<double>& u) {
      const auto q = scalar.infer(p, u);
      return std::inner_product(q.begin(), q.end(), a.begin(), 0.0);
    };
    const std::vector<double> exact_unary(unary.begin(), unary.end());
    double square_error = 0.0, square = 0.0, worst = 0.0;
    const auto compare = [&](double analytic, double numeric) {
      square_error += (analytic - numeric) * (analytic - numeric), square += numeric * numeric;
      worst = std::max(worst, std::abs(analytic - numeric) / (0.05 + std::abs(numeric)));
    };
    const auto expect_small = [&](const char* what) {
      std::printf("%d classes, %s: relative error %.2e, worst %.2e\n", classes, what, std::sqrt(square_error / square),
                  worst);
      EXPECT_GT(square, 1e-4) << what;  // else nothing was compared
      EXPECT_LT(std::sqrt(square_error / square), 1e-4) << what;
      EXPECT_LT(worst, 1e-3) << what;
      square_error = square = worst = 0.0;
    };
    const auto compare_all = [&](std::vector<float> CrfParameters::*member, const std::vector<float>& analytic) {
      for (std::size_t i = 0; i < analytic.size(); ++i) {
        CrfParameters high = parameters, low = parameters;
        (high.*member)[i] += 0x1p-11F, (low.*member)[i] -= 0x1p-11F;  // rounded: divide by what it became
        const double step = static_cast<double>((high.*member)[i]) - static_cast<double>((low.*member)[i]);
        compare(static_cast<double>(analytic[i]), (loss(high, exact_unary) - loss(low, exact_unary)) / step);
      }
    };
    compare_all(&CrfParameters::appearance_weight, gradients.appearance_weight);
    expect_small("appearance weights");
    compare_all(&CrfParameters::smoothness_weight, gradients.smoothness_weight);
    expect_small("smoothness weights");
    compare_all(&CrfParameters::compatibility, gradients.compatibility);
    expect_small("compatibility");
    for (std::size_t i = 0; i < unary.size(); i += 37) {
      auto high = exact_unary, low = exact_unary;
      high[i] += 1e-5, low[i] -= 1e-5;
      compare(static_cast<double>(gradients.unary[i]), (loss(parameters, high) - loss(parameters, low)) / 2e-5);
    }
    expect_small("unary");
  }
}

TEST(DenseCrf, a_tape_holds_every_iteration) {
  const TestPhoto photo = make_photo(20, 18, 4, 91);
  const auto unary = make_unary(photo, 4, 92);
  const DenseCrf crf(photo.view(), thesis);
  const CrfTape tape = crf.record(potts_crf(4, 5.2F, 1.5F, 3), unary);
  ASSERT_EQ(tape.marginals.size(), 4 * unary.size());
  for (int i = 0; i <= 3; ++i) {
    const auto expected = infer(crf, potts_crf(4, 5.2F, 1.5F, i), unary);
    EXPECT_EQ(std::memcmp(expected.data(), &tape.marginals[static_cast<std::size_t>(i) * unary.size()],
                          unary.size() * sizeof(float)),
              0)
        << i;
  }
}

// One lattice serves many threads, and always gives the same bytes.
TEST(DenseCrf, same_bytes_from_any_thread) {
  const TestPhoto photo = make_photo(40, 30, 8, 101);
  const auto unary = make_unary(photo, 8, 102);
  const DenseCrf crf(photo.view(), thesis);
  const auto parameters = potts_crf(8, 5.2F, 1.5F);
  std::vector<std::vector<float>> results(8);
  parallel_for(results.size(), 4, [&](std::size_t i) {
    results[i] = infer(i % 2 == 0 ? crf : DenseCrf(photo.view(), thesis), parameters, unary);
  });
  for (const auto& result : results) EXPECT_EQ(result, results[0]);
}

TEST(DenseCrf, a_workspace_used_before_changes_nothing) {
  CrfWorkspace workspace;
  for (const int size : {30, 12, 45}) {
    const TestPhoto photo = make_photo(size, size, 9, 105);
    const auto unary = make_unary(photo, 9, 106);
    const DenseCrf crf(photo.view(), thesis);
    const auto parameters = potts_crf(9, 5.2F, 1.5F, 4);
    std::vector<float> marginals(unary.size());
    crf.infer(parameters, unary, marginals, &workspace);
    EXPECT_EQ(marginals, infer(crf, parameters, unary)) << size;
  }
}

// The chosen kernels are tested above; the others must not rot.
TEST(CrfKernels, every_processor_family_gives_the_same) {
  for (const int classes : {3, 8, 21, 40, 64}) {
    const TestPhoto photo = make_photo(20, 15, classes, 111);
    const auto unary = make_unary(photo, classes, 112);
    const DenseCrf crf(photo.view(), thesis);
    struct alignas(32) Chunk {
      float v[8];
    };
    const auto chunks = static_cast<std::size_t>(classes + 7) / 8;
    const std::vector<float> weight(8 * chunks, 1.3F);
    std::vector<std::vector<float>> results;
    for (const KernelFamily family : supported_kernel_families()) {
      const CrfKernels& kernels = crf_kernels(static_cast<int>(chunks), family);
      std::vector<Chunk> appearance(crf.appearance().vertices() * chunks),
          smoothness(crf.smoothness().vertices() * chunks);
      const CrfLatticeValues lattices{appearance.data()->v, smoothness.data()->v};
      CrfUpdate update{.pass = {.points = crf.valid_points(),
                                .classes = classes,
                                .values = unary.size(),
                                .appearance_weight = weight.data(),
                                .smoothness_weight = weight.data()},
                       .unary = unary.data(),
                       .out = lattices};
      kernels.update(update);
      for (const BlurAxis& axis : crf.appearance().axes())
        kernels.blur({axis.pairs.data(), axis.pairs.size(), axis.chains.data(), axis.chains.size()},
                     lattices.appearance);
      std::vector<float> marginals(unary.size());
      update.in = lattices, update.out = {}, update.marginals = marginals.data();
      kernels.update(update);
      results.push_back(marginals);
    }
    for (const auto& result : results) EXPECT_EQ(result, results[0]) << classes << " classes";
  }
}

TEST(DenseCrf, refuses_parameters_that_do_not_fit) {
  const TestPhoto photo = make_photo(4, 4, 2, 121);
  const DenseCrf crf(photo.view(), thesis);
  std::vector<float> values(16 * 2);
  CrfParameters parameters = potts_crf(2, 1.0F, 1.0F);
  parameters.compatibility.pop_back();
  EXPECT_THROW(crf.infer(parameters, values, values), OptionError);
  EXPECT_THROW(crf.infer(potts_crf(0, 1.0F, 1.0F), values, values), OptionError);
  EXPECT_THROW(crf.infer(potts_crf(65, 1.0F, 1.0F), values, values), OptionError);
  EXPECT_THROW(crf.infer(potts_crf(2, 1.0F, 1.0F, -1), values, values), OptionError);
  EXPECT_THROW(DenseCrf(photo.view(), {0.0, 11.0, 1.75}), OptionError);
  EXPECT_THROW(DenseCrf(photo.view(), {13.5, std::nan(""), 1.75}), OptionError);
}

}  // namespace
}  // namespace orthodrive
