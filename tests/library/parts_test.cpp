// SPDX-License-Identifier: MIT
// The parts of a trainer, against differences and independent computations.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "library/opened_scene.h"
#include "support/differences.h"

namespace qs {
namespace {

using quadsplat::array_of;
using quadsplat::check;

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// Pictures of a batch, batch x channels x height x width.
struct Batch {
  std::int64_t pictures, channels, height, width;

  std::size_t size() const {
    return static_cast<std::size_t>(pictures * channels * height * width);
  }
  std::vector<double> random(unsigned seed) const {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<float> uniform(-0.2f, 1.2f);
    std::vector<double> values(size());
    for (double& value : values) value = static_cast<double>(uniform(generator));
    return values;
  }
  template <class Real>
  QsArray array(std::vector<Real>& values) const {
    return array_of(values.data(), {pictures, channels, height, width});
  }
};

/// SSIM by its definition, pixel by pixel.
double ssim_by_definition(const Batch& batch, const std::vector<double>& a,
                          const std::vector<double>& b, std::int64_t margin) {
  const auto weight = [](std::int64_t k) {
    double sum = 0;
    for (int i = -5; i <= 5; ++i) sum += std::exp(-i * i / 4.5);
    return std::exp(-static_cast<double>(k * k) / 4.5) / sum;
  };
  double total = 0;
  std::int64_t counted = 0;
  for (std::int64_t plane = 0; plane < batch.pictures * batch.channels; ++plane) {
    for (std::int64_t y = margin; y < batch.height - margin; ++y) {
      for (std::int64_t x = margin; x < batch.width - margin; ++x) {
        double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
        for (std::int64_t j = std::max<std::int64_t>(0, y - 5);
             j <= std::min(batch.height - 1, y + 5); ++j) {
          for (std::int64_t i = std::max<std::int64_t>(0, x - 5);
               i <= std::min(batch.width - 1, x + 5); ++i) {
            const double w = weight(i - x) * weight(j - y);
            const auto at = static_cast<std::size_t>((plane * batch.height + j) * batch.width + i);
            ma += w * a[at];
            mb += w * b[at];
            aa += w * a[at] * a[at];
            bb += w * b[at] * b[at];
            ab += w * a[at] * b[at];
          }
        }
        constexpr double kC1 = 1e-4, kC2 = 9e-4;
        total += (2 * ma * mb + kC1) * (2 * (ab - ma * mb) + kC2) /
                 ((ma * ma + mb * mb + kC1) * (aa - ma * ma + bb - mb * mb + kC2));
        ++counted;
      }
    }
  }
  return total / static_cast<double>(counted);
}

template <class Real>
double ssim_of(quadsplat::Context& context, const Batch& batch, std::vector<Real> a,
               std::vector<Real> b, std::uint32_t border = QS_BORDER_ZEROS) {
  return context.ssim(batch.array(a), batch.array(b), border);
}

template <class Real>
std::vector<Real> ssim_gradient(quadsplat::Context& context, const Batch& batch,
                                std::vector<Real> a, std::vector<Real> b, std::uint32_t border,
                                double by_mean = 1) {
  std::vector<Real> gradient(batch.size());
  const QsArray first = batch.array(a), second = batch.array(b), by_a = batch.array(gradient);
  check(qs_ssim_backward, context.get(), &first, &second, border, by_mean, &by_a);
  return gradient;
}

template <class To, class From>
std::vector<To> cast(const std::vector<From>& values) {
  return {values.begin(), values.end()};
}

TEST(LibrarySsim, is_its_definition) {
  quadsplat::Context context = test::cpu();
  for (const Batch& batch : {Batch{2, 3, 13, 17}, Batch{1, 1, 1, 1}, Batch{1, 2, 30, 3}}) {
    const auto a = batch.random(1), b = batch.random(2);
    const double expected = ssim_by_definition(batch, a, b, 0);
    EXPECT_NEAR(ssim_of(context, batch, a, b), expected, 1e-9);
    EXPECT_NEAR(ssim_of(context, batch, cast<float>(a), cast<float>(b)), expected, 1e-4);
    EXPECT_NEAR(ssim_of(context, batch, a, a), 1, 1e-12);
  }
  const Batch smallest{1, 2, 11, 12};
  const auto a = smallest.random(3), b = smallest.random(4);
  EXPECT_NEAR(ssim_of(context, smallest, a, b, QS_BORDER_CROP),
              ssim_by_definition(smallest, a, b, 5), 1e-9);
}

TEST(LibrarySsim, is_that_of_compare) {
  quadsplat::Context context = test::cpu();
  const Batch batch{1, 3, 20, 30};
  std::vector<double> a = batch.random(1), b = batch.random(2);
  for (double& value : a) value = std::clamp(value, 0.0, 1.0);
  for (double& value : b) value = std::clamp(value, 0.0, 1.0);
  for (const std::uint32_t border : {QS_BORDER_ZEROS, QS_BORDER_CROP}) {
    auto asked = quadsplat::sized<QsComparison>();
    asked.metrics = QS_METRIC_SSIM;
    asked.ssim_border = border;
    EXPECT_NEAR(ssim_of(context, batch, a, b, border),
                context
                    .compare(quadsplat::planes_of(a.data(), 20, 30),
                             quadsplat::planes_of(b.data(), 20, 30), asked)
                    .ssim,
                1e-9);
  }
}

TEST(LibrarySsim, has_the_gradient_of_differences) {
  quadsplat::Context context = test::cpu(1);
  const Batch batch{1, 2, 12, 11};
  const auto a = batch.random(5), b = batch.random(6);
  for (const std::uint32_t border : {QS_BORDER_ZEROS, QS_BORDER_CROP}) {
    const auto expected = test::differences(
        [&](const auto& values) { return 3 * ssim_of(context, batch, values, b, border); }, a,
        1e-6);
    test::expect_close(ssim_gradient(context, batch, a, b, border, 3), expected, 1e-6);
    test::expect_close(ssim_gradient(context, batch, cast<float>(a), cast<float>(b), border, 3),
                       expected, 1e-3);
  }
}

TEST(LibrarySsim, does_not_depend_on_threads_and_strides) {
  const Batch batch{2, 3, 40, 50};
  auto a = cast<float>(batch.random(7)), b = cast<float>(batch.random(8));
  quadsplat::Context one = test::cpu(1), three = test::cpu(3);
  EXPECT_EQ(ssim_of(one, batch, a, b), ssim_of(three, batch, a, b));
  const auto gradient = ssim_gradient(one, batch, a, b, QS_BORDER_CROP);
  EXPECT_EQ(ssim_gradient(three, batch, a, b, QS_BORDER_CROP), gradient);
  // b with its channels interleaved, the gradient upside down, in the memory of a copy of a.
  std::vector<float> interleaved(b.size()), flipped = a;
  QsArray second = array_of(interleaved.data(), {2, 3, 40, 50});
  second.strides[1] = 1;
  second.strides[2] = 50 * 3;
  second.strides[3] = 3;
  QsArray first = batch.array(flipped);
  first.strides[2] = -50;
  first.data = flipped.data() + 39 * 50;
  for (std::int64_t p = 0; p < 6; ++p) {
    for (std::int64_t y = 0; y < 40; ++y) {
      for (std::int64_t x = 0; x < 50; ++x) {
        interleaved[static_cast<std::size_t>(p / 3 * 6000 + p % 3 + y * 150 + x * 3)] =
            b[static_cast<std::size_t>(p * 2000 + y * 50 + x)];
        flipped[static_cast<std::size_t>(p * 2000 + (39 - y) * 50 + x)] =
            a[static_cast<std::size_t>(p * 2000 + y * 50 + x)];
      }
    }
  }
  check(qs_ssim_backward, three.get(), &first, &second, QS_BORDER_CROP, 1.0, &first);
  for (std::size_t i = 0; i < gradient.size(); ++i)
    ASSERT_EQ(flipped[i / 2000 * 2000 + (39 - i / 50 % 40) * 50 + i % 50], gradient[i]);
}

TEST(LibrarySsim, of_values_that_are_not_finite_is_nan) {
  quadsplat::Context context = test::cpu();
  const Batch batch{1, 1, 20, 20};
  auto a = batch.random(1);
  a[0] = kNoNumber;
  EXPECT_TRUE(std::isnan(ssim_of(context, batch, a, batch.random(2))));
}

TEST(LibrarySsim, refuses_other_pictures) {
  quadsplat::Context context = test::cpu(1);
  const Batch batch{1, 2, 10, 12};
  auto a = batch.random(1), b = batch.random(2);
  auto floats = cast<float>(b);
  double mean = 7;
  const auto refused = [&](const QsArray& first, const QsArray& second,
                           std::uint32_t border = QS_BORDER_ZEROS) {
    return test::sentence_of(
        [&] { check(qs_ssim, context.get(), &first, &second, border, &mean); });
  };
  EXPECT_EQ(refused(array_of(a.data(), {2, 10, 12}), batch.array(b)),
            "qs_ssim: a: has 3 dimensions instead of 4");
  EXPECT_EQ(refused(array_of(a.data(), {1, 2, 0, 12}), batch.array(b)),
            "qs_ssim: a: its size of dimension 2 is 0");
  EXPECT_EQ(refused(array_of(a.data(), {1, 1, 1 << 15, 1 << 15}), batch.array(b)),
            "qs_ssim: a: 32768 x 32768 pixels are too many");
  EXPECT_EQ(refused(batch.array(a), array_of(b.data(), {2, 1, 10, 12})),
            "qs_ssim: b: has 2 x 1 x 10 x 12 elements instead of 1 x 2 x 10 x 12");
  EXPECT_EQ(refused(batch.array(a), batch.array(floats)),
            "qs_ssim: b: has elements of type float32 instead of float64");
  EXPECT_EQ(refused(batch.array(a), batch.array(b), QS_BORDER_CROP),
            "qs_ssim: border: QS_BORDER_CROP needs 11 pixels along each side, not 12 x 10");
  EXPECT_EQ(refused(batch.array(a), batch.array(b), 2), "qs_ssim: border: is 2");
  QsArray on_gpu = batch.array(a);
  on_gpu.memory = QS_MEMORY_CUDA;
  EXPECT_EQ(refused(on_gpu, batch.array(b)),
            "qs_ssim: a: is in the memory of a GPU, but this array must be in host memory");
  EXPECT_EQ(mean, 7);
  const QsArray first = batch.array(a), second = batch.array(b);
  QsArray spread = batch.array(b);
  spread.strides[3] = 0;
  EXPECT_EQ(test::sentence_of([&] {
              check(qs_ssim_backward, context.get(), &first, &second, QS_BORDER_ZEROS, 1.0,
                    &spread);
            }),
            "qs_ssim_backward: by_a: its stride of dimension 3 is 0, so that elements would be "
            "overwritten");
  char message[QS_MESSAGE_BYTES];
  EXPECT_EQ(qs_ssim(nullptr, &first, &second, 0, &mean, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_ssim: context: is null");
  EXPECT_EQ(qs_ssim(context.get(), &first, &second, 0, nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_ssim: mean: is null");
  EXPECT_EQ(qs_ssim_backward(context.get(), &first, &second, 0, 1, nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_ssim_backward: by_a: is null");
}

std::vector<double> neighbours(quadsplat::Context& context, std::vector<float> points) {
  const auto count = static_cast<std::int64_t>(points.size() / 3);
  std::vector<double> distances2(points.size() / 3, -1);
  const QsArray given = array_of(points.data(), {count, 3});
  const QsArray wanted = array_of(distances2.data(), {count});
  check(qs_neighbours, context.get(), &given, &wanted);
  return distances2;
}

TEST(LibraryNeighbours, are_the_nearest_three_of_all) {
  std::mt19937 generator(1);
  std::normal_distribution<float> normal;
  std::vector<float> points(3 * 500);
  for (float& value : points) value = std::round(8 * normal(generator)) / 8;  // some are equal
  quadsplat::Context one = test::cpu(1), three = test::cpu(3);
  const auto found = neighbours(one, points);
  EXPECT_EQ(neighbours(three, points), found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    std::vector<double> all;
    for (std::size_t k = 0; k < found.size(); ++k) {
      double sum = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        sum += std::pow(static_cast<double>(points[3 * i + axis] - points[3 * k + axis]), 2);
      if (k != i) all.push_back(sum);
    }
    std::sort(all.begin(), all.end());
    ASSERT_NEAR(found[i], (all[0] + all[1] + all[2]) / 3, 1e-12);
  }
}

TEST(LibraryNeighbours, of_few_points_are_the_others) {
  quadsplat::Context context = test::cpu();
  EXPECT_EQ(neighbours(context, {}), std::vector<double>{});
  EXPECT_EQ(neighbours(context, {1, 2, 3}), std::vector<double>{0});
  EXPECT_EQ(neighbours(context, {0, 0, 0, 0, 3, 4}), (std::vector<double>{25, 25}));
  EXPECT_EQ(neighbours(context, {0, 0, 0, 0, 0, 1, 0, 0, 3}), (std::vector<double>{5, 2.5, 6.5}));
  EXPECT_EQ(neighbours(context, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2}),
            (std::vector<double>{0, 0, 0, 0, 1}));
}

TEST(LibraryNeighbours, are_finite_points) {
  quadsplat::Context context = test::cpu();
  const float no_number = static_cast<float>(kNoNumber);
  const auto found = neighbours(
      context, {0, 0, 0, no_number, 0, 0, 0, 0, 2, 0, std::numeric_limits<float>::infinity(), 0});
  EXPECT_EQ(found[0], 4);
  EXPECT_TRUE(std::isnan(found[1]));
  EXPECT_EQ(found[2], 4);
  EXPECT_TRUE(std::isnan(found[3]));
  EXPECT_TRUE(std::isnan(neighbours(context, {no_number, 0, 0})[0]));
}

TEST(LibraryNeighbours, take_strides_and_refuse_other_arrays) {
  quadsplat::Context context = test::cpu(1);
  std::vector<float> columns = {0, 0, 1, 0, 3, 2};  // points (0, 1, 3) and (0, 0, 2)
  std::vector<float> found(4, -1);
  QsArray points = array_of(columns.data(), {2, 3});
  points.strides[0] = 1;
  points.strides[1] = 2;
  QsArray wanted = array_of(found.data(), {2});
  wanted.strides[0] = 2;
  check(qs_neighbours, context.get(), &points, &wanted);
  EXPECT_EQ(found, (std::vector<float>{2, -1, 2, -1}));
  const auto refused = [&](const QsArray& given) {
    return test::sentence_of([&] { check(qs_neighbours, context.get(), &given, &wanted); });
  };
  std::vector<double> doubles(6);
  EXPECT_EQ(refused(array_of(columns.data(), {3, 2})),
            "qs_neighbours: points: has 3 x 2 elements instead of 3 x 3");
  EXPECT_EQ(refused(array_of(doubles.data(), {2, 3})),
            "qs_neighbours: points: has elements of type float64 instead of float32");
  EXPECT_EQ(refused(array_of(columns.data(), {1, 3})),
            "qs_neighbours: distances2: has 2 elements instead of 1");
  EXPECT_EQ(refused(QsArray{}), "qs_neighbours: points: is absent: it needs 2 dimensions");
}

/// Opacities and scales with their copies.
template <class Real>
struct Relocated {
  std::vector<Real> opacities, scales;

  Relocated(quadsplat::Context& context, std::vector<Real> old_opacities,
            std::vector<Real> old_scales, std::vector<std::int64_t> counts)
      : opacities(old_opacities.size()), scales(old_scales.size()) {
    const auto count = static_cast<std::int64_t>(counts.size());
    const QsArray in[3] = {array_of(old_opacities.data(), {count}),
                           array_of(old_scales.data(), {count, 3}),
                           array_of(counts.data(), {count})};
    const QsArray out[2] = {array_of(opacities.data(), {count}),
                            array_of(scales.data(), {count, 3})};
    check(qs_relocate, context.get(), &in[0], &in[1], &in[2], &out[0], &out[1]);
  }
};

TEST(LibraryRelocate, follows_equation_9) {
  quadsplat::Context context = test::cpu();
  const std::vector<double> opacities = {0.5, 0.5, 0.9, 1, 0};
  const std::vector<double> scales(15, 2);
  const Relocated<double> found(context, opacities, scales, {1, 2, 3, 2, 4});
  EXPECT_EQ(found.opacities[0], 0.5);
  EXPECT_EQ(found.scales[0], 2);
  const double two = 1 - std::sqrt(0.5), three = 1 - std::cbrt(0.1);
  EXPECT_NEAR(found.opacities[1], two, 1e-15);
  EXPECT_NEAR(found.scales[4], 2 * 0.5 / (2 * two - two * two / std::sqrt(2.0)), 1e-12);
  EXPECT_NEAR(found.opacities[2], three, 1e-15);
  EXPECT_NEAR(found.scales[8],
              2 * 0.9 /
                  (3 * three - 3 * std::pow(three, 2) / std::sqrt(2.0) +
                   std::pow(three, 3) / std::sqrt(3.0)),
              1e-12);
  EXPECT_EQ(found.opacities[3], 1);
  EXPECT_NEAR(found.scales[9], 2 / (2 - std::sqrt(0.5)), 1e-12);
  EXPECT_EQ(found.opacities[4], 0);
  EXPECT_EQ(found.scales[12], 2);
}

TEST(LibraryRelocate, leaves_impossible_opacities_and_limits_the_copies) {
  quadsplat::Context context = test::cpu();
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  const float no_number = static_cast<float>(kNoNumber);
  const Relocated<float> found(context, {no_number, -0.1f, 1.1f, 0.5f, 0.5f, 0.5f},
                               std::vector<float>(18, 3), {2, 2, 2, -kMost, kMost, 51});
  EXPECT_TRUE(std::isnan(found.opacities[0]));
  EXPECT_EQ(found.opacities[1], -0.1f);
  EXPECT_EQ(found.opacities[2], 1.1f);
  EXPECT_EQ(found.opacities[3], 0.5f);
  EXPECT_EQ(std::vector<float>(12, 3),
            std::vector<float>(found.scales.begin(), found.scales.begin() + 12));
  EXPECT_EQ(found.opacities[4], found.opacities[5]);
  EXPECT_EQ(found.scales[12], found.scales[15]);
  EXPECT_LT(found.opacities[5], 0.02f);
  const Relocated<float> nothing(context, {}, {}, {});
  EXPECT_TRUE(nothing.opacities.empty());
}

TEST(LibraryRelocate, works_in_place_and_refuses_other_arrays) {
  quadsplat::Context context = test::cpu(1);
  std::vector<float> opacities = {0.5f, 0.25f}, scales = {1, 2, 3, 4, 5, 6};
  std::vector<std::int32_t> counts = {2, 3};
  const Relocated<float> expected(context, opacities, scales, {2, 3});
  QsArray in[3] = {array_of(opacities.data(), {2}), array_of(scales.data(), {2, 3}),
                   array_of(counts.data(), {2})};
  const auto relocate = [&](const QsArray& new_opacities) {
    return test::sentence_of(
        [&] { check(qs_relocate, context.get(), &in[0], &in[1], &in[2], &new_opacities, &in[1]); });
  };
  std::vector<double> doubles(2);
  EXPECT_EQ(relocate(array_of(doubles.data(), {2})),
            "qs_relocate: new_opacities: has elements of type float64 instead of float32");
  EXPECT_EQ(relocate(in[0]), "");
  EXPECT_EQ(opacities, expected.opacities);
  EXPECT_EQ(scales, expected.scales);
  in[2] = array_of(opacities.data(), {2});
  EXPECT_EQ(relocate(in[0]),
            "qs_relocate: counts: has elements of type float32 instead of int32 or uint32 or int64 "
            "or uint64");
  in[1] = array_of(scales.data(), {3, 2});
  EXPECT_EQ(relocate(in[0]), "qs_relocate: scales: has 3 x 2 elements instead of 2 x 3");
}

/// A step of Adam over rows of `columns` values, and its expected result.
struct Step {
  std::int64_t rows = 5, columns = 3;
  std::vector<float> values = numbers(1), gradients = numbers(2), first = numbers(3),
                     second = numbers(4);
  std::vector<std::uint8_t> visible = {1, 0, 255, 1, 1};
  QsAdam adam = quadsplat::default_adam();

  Step() {
    for (float& moment : second) moment = std::abs(moment);
    adam.rate = 0.1;
    adam.values = array_of(values.data(), {rows, columns});
    adam.gradients = array_of(gradients.data(), {rows, columns});
    adam.first = array_of(first.data(), {rows, columns});
    adam.second = array_of(second.data(), {rows, columns});
    adam.visible = array_of(visible.data(), {rows});
  }
  Step(const Step&) = delete;

  std::vector<float> numbers(unsigned seed) const {
    std::mt19937 generator(seed);
    std::normal_distribution<float> normal;
    std::vector<float> made(static_cast<std::size_t>(rows * columns));
    for (float& number : made) number = normal(generator);
    return made;
  }
  std::string take(quadsplat::Context& context) {
    return test::sentence_of([&] { context.step(adam); });
  }
};

TEST(LibraryAdam, moves_the_visible_rows_by_the_formula) {
  quadsplat::Context context = test::cpu();
  for (const std::uint64_t number : {0u, 1u, 7u}) {
    Step step;
    const Step before;
    step.adam.step = number;
    step.adam.beta1 = 0.8;
    step.adam.beta2 = 0.99;
    step.adam.epsilon = 0.5;
    EXPECT_EQ(step.take(context), "");
    for (std::size_t i = 0; i < step.values.size(); ++i) {
      if (step.visible[i / 3] == 0) {
        EXPECT_EQ(step.values[i], before.values[i]);
        EXPECT_EQ(step.first[i], before.first[i]);
        EXPECT_EQ(step.second[i], before.second[i]);
        continue;
      }
      const double g = before.gradients[i], t = static_cast<double>(number);
      const double m = 0.8 * before.first[i] + 0.2 * g, v = 0.99 * before.second[i] + 0.01 * g * g;
      const double unbiased_m = number == 0 ? m : m / (1 - std::pow(0.8, t));
      const double unbiased_v = number == 0 ? v : v / (1 - std::pow(0.99, t));
      EXPECT_NEAR(step.first[i], m, 1e-6);
      EXPECT_NEAR(step.second[i], v, 1e-6);
      EXPECT_NEAR(step.values[i],
                  before.values[i] - 0.1 * unbiased_m / (std::sqrt(unbiased_v) + 0.5), 1e-5);
    }
  }
}

TEST(LibraryAdam, takes_any_shape_and_number_of_threads) {
  quadsplat::Context one = test::cpu(1), three = test::cpu(3);
  Step flat, deep;
  flat.adam.visible = QsArray{};
  deep.adam.visible = QsArray{};
  for (QsArray* array : {&deep.adam.values, &deep.adam.first, &deep.adam.second})
    *array = array_of(static_cast<float*>(array->data), {1, 5, 1, 3});
  // The gradients column by column.
  std::vector<float> columns(15);
  for (std::size_t i = 0; i < 15; ++i) columns[i % 3 * 5 + i / 3] = deep.gradients[i];
  deep.adam.gradients = array_of(columns.data(), {1, 5, 1, 3});
  deep.adam.gradients.strides[1] = 1;
  deep.adam.gradients.strides[3] = 5;
  EXPECT_EQ(flat.take(one), "");
  EXPECT_EQ(deep.take(three), "");
  EXPECT_EQ(flat.values, deep.values);
  EXPECT_EQ(flat.second, deep.second);
  Step single;
  for (QsArray* array :
       {&single.adam.values, &single.adam.gradients, &single.adam.first, &single.adam.second})
    *array = array_of(static_cast<float*>(array->data), {5});
  EXPECT_EQ(single.take(one), "");
  Step none;
  for (QsArray* array :
       {&none.adam.values, &none.adam.gradients, &none.adam.first, &none.adam.second})
    *array = array_of(static_cast<float*>(array->data), {0, 3});
  none.adam.visible = array_of(none.visible.data(), {0});
  EXPECT_EQ(none.take(one), "");
}

TEST(LibraryAdam, never_makes_a_value_that_is_not_finite) {
  quadsplat::Context context = test::cpu(1);
  Step step;
  const float before = step.values[1];
  step.adam.epsilon = 0;
  step.gradients = {static_cast<float>(kNoNumber), std::numeric_limits<float>::infinity(), 0,
                    std::numeric_limits<float>::max(), 1e-30f};
  step.gradients.resize(15);
  step.adam.gradients = array_of(step.gradients.data(), {5, 3});
  std::fill(step.first.begin(), step.first.end(), 0.0f);
  std::fill(step.second.begin(), step.second.end(), 0.0f);
  EXPECT_EQ(step.take(context), "");
  EXPECT_EQ(step.values[1], before);
  for (const float value : step.values) EXPECT_TRUE(std::isfinite(value));
}

TEST(LibraryAdam, refuses_numbers_and_arrays_that_do_not_fit) {
  quadsplat::Context context = test::cpu(1);
  Step step;
  const Step before;
  const auto refused = [&](auto QsAdam::*member, auto value) {
    const QsAdam kept = step.adam;
    step.adam.*member = value;
    const std::string sentence = step.take(context);
    step.adam = kept;
    return sentence;
  };
  EXPECT_EQ(refused(&QsAdam::size, 8u),
            "qs_adam: adam.size: is 8: set it to the size of the struct, 496 bytes in this "
            "library");
  EXPECT_EQ(refused(&QsAdam::reserved, 1u), "qs_adam: adam.reserved: is not 0");
  EXPECT_EQ(refused(&QsAdam::rate, kNoNumber), "qs_adam: adam.rate: is nan");
  EXPECT_EQ(refused(&QsAdam::beta1, 1.0), "qs_adam: adam.beta1: 1 is not at least 0 and below 1");
  EXPECT_EQ(refused(&QsAdam::beta2, -0.5),
            "qs_adam: adam.beta2: -0.5 is not at least 0 and below 1");
  EXPECT_EQ(refused(&QsAdam::epsilon, -1.0),
            "qs_adam: adam.epsilon: -1 is not finite and at least 0");
  EXPECT_EQ(refused(&QsAdam::values, QsArray{}),
            "qs_adam: adam.values: has 0 dimensions instead of 1 to 4");
  EXPECT_EQ(refused(&QsAdam::gradients, array_of(step.gradients.data(), {3, 5})),
            "qs_adam: adam.gradients: has 3 x 5 elements instead of 5 x 3");
  EXPECT_EQ(refused(&QsAdam::visible, array_of(step.visible.data(), {3})),
            "qs_adam: adam.visible: has 3 elements instead of 5");
  QsArray spread = step.adam.first;
  spread.strides[0] = 0;
  EXPECT_EQ(refused(&QsAdam::first, spread),
            "qs_adam: adam.first: its stride of dimension 0 is 0, so that elements would be "
            "overwritten");
  EXPECT_EQ(step.values, before.values);
  char message[QS_MESSAGE_BYTES];
  EXPECT_EQ(qs_adam(context.get(), nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_adam: adam: is null");
}

}  // namespace
}  // namespace qs
