// SPDX-License-Identifier: MIT
// The Gaussians of a scene in the arrays of the caller.
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "library/opened_scene.h"
#include "raster/scene/activated_cloud.h"
#include "support/scene_files.h"
#include "support/scenes.h"

namespace qs {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Arrays for `count` Gaussians with K coefficients. All elements begin as -77.
template <class Real>
struct Copied : QsGaussians {
  std::vector<Real> means_of, scales_of, rotations_of, opacities_of, colors_of;

  Copied(std::size_t count, std::size_t coefficients)
      : QsGaussians(quadsplat::sized<QsGaussians>()),
        means_of(3 * count, -77),
        scales_of(3 * count, -77),
        rotations_of(4 * count, -77),
        opacities_of(count, -77),
        colors_of(3 * coefficients * count, -77) {
    using quadsplat::array_of;
    const auto rows = static_cast<std::int64_t>(count);
    means = array_of(means_of.data(), {rows, 3});
    scales = array_of(scales_of.data(), {rows, 3});
    rotations = array_of(rotations_of.data(), {rows, 4});
    opacities = array_of(opacities_of.data(), {rows});
    colors = array_of(colors_of.data(), {rows, static_cast<std::int64_t>(coefficients), 3});
  }
  Copied(const Copied&) = delete;
};

/// Expects the values of the cloud, as logarithms and logits.
template <class Real>
void expect_values(const Copied<Real>& copied, const GaussianCloud& cloud) {
  const auto expect = [](const std::vector<Real>& values, const float* expected) {
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_EQ(values[i], static_cast<Real>(expected[i])) << i;
  };
  const test::CloudArrays arrays(cloud);
  expect(copied.means_of, &cloud.positions[0].x);
  expect(copied.scales_of, &cloud.log_scales[0].x);
  expect(copied.rotations_of, arrays.quaternions.data());
  expect(copied.opacities_of, cloud.opacity_logits.data());
  expect(copied.colors_of, &cloud.sh[0].x);
}

/// The cloud with rotations of length 1, as the library keeps them.
GaussianCloud cloud_of(std::size_t count, int degree) {
  GaussianCloud cloud = test::random_cloud(count, degree, 7);
  for (glm::quat& q : cloud.rotations) q = glm::quat(glm::normalize(glm::dquat(q)));
  return cloud;
}

TEST(LibraryGaussians, come_back_as_they_were_given) {
  const GaussianCloud cloud = cloud_of(3000, 2);  // more than a chunk
  for (const int threads : {1, 3}) {
    quadsplat::Context context = test::cpu(threads);
    quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
    Copied<float> floats(3000, 9);
    scene.gaussians(floats);
    expect_values(floats, cloud);
    Copied<double> doubles(3000, 9);
    scene.gaussians(doubles);
    expect_values(doubles, cloud);
  }
}

TEST(LibraryGaussians, of_a_file_are_its_own) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const Scene read = test::read_scene(test::plush());
  Copied<float> copied(read.cloud.size(),
                       static_cast<std::size_t>(sh_coefficient_count(read.cloud.sh_degree)));
  scene.gaussians(copied);
  expect_values(copied, read.cloud);
  // A scene of these arrays draws the same bits.
  const QsCamera camera = test::plush_camera(32, 120, 90);
  quadsplat::Scene again = context.wrap(copied);
  EXPECT_EQ(test::colors(again, camera), test::colors(scene, camera));
}

TEST(LibraryGaussians, are_activated_in_double_precision) {
  GaussianCloud cloud = cloud_of(50, 0);
  cloud.opacity_logits[0] = kInfinity;
  cloud.opacity_logits[1] = -kInfinity;
  cloud.log_scales[0].y = -kInfinity;
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
  Copied<float> floats(50, 1);
  Copied<double> doubles(50, 1);
  floats.is_activated = doubles.is_activated = 1;
  scene.gaussians(floats);
  scene.gaussians(doubles);
  for (std::size_t i = 0; i < 50; ++i) {
    const double opacity = opacity_of_logit(cloud.opacity_logits[i]);
    EXPECT_EQ(doubles.opacities_of[i], opacity);
    EXPECT_EQ(floats.opacities_of[i], static_cast<float>(opacity));
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t place = 3 * i + static_cast<std::size_t>(axis);
      const double scale = std::exp(static_cast<double>(cloud.log_scales[i][axis]));
      EXPECT_EQ(doubles.scales_of[place], scale);
      EXPECT_EQ(floats.scales_of[place], static_cast<float>(scale));
      EXPECT_EQ(floats.means_of[place], cloud.positions[i][axis]);
    }
  }
  EXPECT_EQ(floats.opacities_of[0], 1.0f);
  EXPECT_EQ(floats.opacities_of[1], 0.0f);
  EXPECT_EQ(floats.scales_of[1], 0.0f);
}

TEST(LibraryGaussians, have_rotations_of_length_1) {
  GaussianCloud cloud = cloud_of(1, 0);
  cloud.rotations[0] = glm::quat(0, 3, 0, 4);  // w x y z
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
  Copied<float> copied(1, 1);
  scene.gaussians(copied);
  EXPECT_EQ(copied.rotations_of, (std::vector<float>{0, 0.6f, 0, 0.8f}));
}

TEST(LibraryGaussians, go_to_any_strides_and_nowhere_else) {
  constexpr std::size_t kCount = 20;
  const GaussianCloud cloud = cloud_of(kCount, 1);
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
  // In reverse order, with 3 unused values behind every row of 4 x 3.
  std::vector<double> colors(15 * kCount, -77.0);
  auto given = quadsplat::sized<QsGaussians>();
  given.colors = quadsplat::array_of(colors.data() + 15 * (kCount - 1), {kCount, 4, 3});
  given.colors.strides[0] = -15;
  // Axis by axis, every second value.
  std::vector<float> means(2 * 3 * kCount, -77.0f);
  given.means = quadsplat::array_of(means.data(), {kCount, 3});
  given.means.strides[0] = 2;
  given.means.strides[1] = 2 * kCount;
  scene.gaussians(given);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double* const row = colors.data() + 15 * (kCount - 1 - i);
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t c = 0; c < 3; ++c) {
        const glm::vec3& color = cloud.sh[4 * i + k];
        EXPECT_EQ(row[3 * k + c], static_cast<double>(color[static_cast<int>(c)]));
      }
    EXPECT_EQ(std::vector<double>(row + 12, row + 15), std::vector<double>(3, -77.0));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(means[2 * (axis * kCount + i)], cloud.positions[i][static_cast<int>(axis)]);
      EXPECT_EQ(means[2 * (axis * kCount + i) + 1], -77.0f);
    }
  }
}

TEST(LibraryGaussians, have_dc_and_rest_in_two_arrays_and_fewer_coefficients) {
  constexpr std::size_t kCount = 40;
  const GaussianCloud cloud = cloud_of(kCount, 3);
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
  for (const std::size_t coefficients : {1u, 4u, 9u, 16u}) {
    Copied<float> whole(kCount, coefficients), parts(kCount, 1);
    scene.gaussians(whole);
    const auto rest = static_cast<std::int64_t>(coefficients) - 1;
    std::vector<float> rest_of(3 * kCount * (coefficients - 1));
    parts.rest = quadsplat::array_of(rest_of.data(), {kCount, rest, 3});
    scene.gaussians(parts);
    for (std::size_t i = 0; i < kCount; ++i)
      for (std::size_t k = 0; k < coefficients; ++k)
        for (std::size_t c = 0; c < 3; ++c) {
          const float expected = cloud.sh[16 * i + k][static_cast<int>(c)];
          EXPECT_EQ(whole.colors_of[3 * (coefficients * i + k) + c], expected);
          EXPECT_EQ(k == 0 ? parts.colors_of[3 * i + c]
                           : rest_of[3 * ((coefficients - 1) * i + k - 1) + c],
                    expected);
        }
  }
}

TEST(LibraryGaussians, that_are_not_drawn_are_nan_and_the_others_keep_their_numbers) {
  quadsplat::Context context = test::cpu();
  const GaussianCloud sound = cloud_of(2500, 0);
  for (const std::vector<std::size_t>& bad :
       {std::vector<std::size_t>{0}, {2499}, {1023, 1024, 1025}, {0, 5, 1024, 2048, 2499}}) {
    GaussianCloud spoilt = sound;
    for (const std::size_t i : bad) spoilt.opacity_logits[i] = kNaN;
    quadsplat::Scene scene = context.wrap(test::gaussians_of(spoilt));
    Copied<float> copied(2500, 1);
    copied.is_activated = 1;
    scene.gaussians(copied);
    std::size_t next = 0;
    for (std::size_t i = 0; i < 2500; ++i) {
      const bool is_bad = next < bad.size() && bad[next] == i;
      if (is_bad) ++next;
      for (const float value :
           {copied.means_of[3 * i + 2], copied.scales_of[3 * i], copied.rotations_of[4 * i + 3],
            copied.opacities_of[i], copied.colors_of[3 * i + 1]}) {
        ASSERT_EQ(std::isnan(value), is_bad) << i;
      }
      if (!is_bad) {
        ASSERT_EQ(copied.means_of[3 * i + 2], sound.positions[i].z) << i;
      }
    }
    // The copied Gaussians are a scene of the same numbers.
    EXPECT_EQ(context.wrap(copied).facts().not_drawn, bad.size());
  }
  GaussianCloud none = cloud_of(2, 1);
  for (float& logit : none.opacity_logits) logit = kNaN;
  Copied<double> copied(2, 4);
  context.wrap(test::gaussians_of(none)).gaussians(copied);
  for (const double value : copied.colors_of) EXPECT_TRUE(std::isnan(value));
}

TEST(LibraryGaussians, may_be_none_and_arrays_may_be_absent) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene empty = context.wrap(test::gaussians_of(GaussianCloud{}));
  const Copied<float> nothing(0, 1);
  EXPECT_EQ(test::sentence_of([&] { empty.gaussians(nothing); }), "");
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud_of(3, 0)));
  EXPECT_EQ(test::sentence_of([&] { scene.gaussians(quadsplat::sized<QsGaussians>()); }), "");
}

TEST(LibraryGaussians, are_refused_in_wrong_arrays_with_a_sentence) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud_of(5, 1)));
  const struct {
    std::function<void(QsGaussians&)> spoil;
    const char* sentence;
  } cases[] = {
      {[](QsGaussians& g) { g.size = 543; }, "size: is 543: set it to the size of the struct, "},
      {[](QsGaussians& g) { g.is_activated = 2; }, "is_activated: is 2"},
      {[](QsGaussians& g) { g.colors_are = 2; }, "colors_are: is 2"},
      {[](QsGaussians& g) { g.colors_are = QS_COLORS_RGB; },
       "colors_are: is QS_COLORS_RGB, but scenes have spherical harmonics"},
      {[](QsGaussians& g) { g.antialiased = 1; },
       "antialiased: is 1 instead of 0: qs_scene_facts() has it"},
      {[](QsGaussians& g) { g.means.sizes[0] = 4; }, "means: has 4 x 3 elements instead of 5 x 3"},
      {[](QsGaussians& g) { g.scales.sizes[1] = 1; },
       "scales: has 5 x 1 elements instead of 5 x 3"},
      {[](QsGaussians& g) { g.rotations.dimensions = 1; },
       "rotations: has 1 dimensions instead of 2"},
      {[](QsGaussians& g) { g.opacities.sizes[0] = 6; }, "opacities: has 6 elements instead of 5"},
      {[](QsGaussians& g) { g.opacities.type = QS_UINT8; },
       "opacities: has elements of type uint8 instead of float32 or float64"},
      {[](QsGaussians& g) { g.rotations.memory = QS_MEMORY_CUDA; },
       "rotations: is in the memory of a GPU, "},
      {[](QsGaussians& g) { g.means.strides[0] = 0; },
       "means: its stride of dimension 0 is 0, so that elements would be overwritten"},
      {[](QsGaussians& g) { g.scales.data = nullptr; }, "scales: its data is null"},
      {[](QsGaussians& g) { g.colors.sizes[1] = 9; },
       "colors: 9 coefficients are more than the scene's 4"},
      {[](QsGaussians& g) { g.colors.sizes[1] = 3; },
       "colors: 3 coefficients of spherical harmonics are not 1, 4, 9 or 16"},
      {[](QsGaussians& g) { g.rest = g.colors; },
       "colors: has 4 coefficients instead of the DC alone"},
      {[](QsGaussians& g) {
         g.rest = g.colors;
         g.colors = QsArray QS_ABSENT;
       },
       "colors: is absent: it needs 3 dimensions"},
  };
  for (const auto& one : cases) {
    Copied<float> copied(5, 4);
    QsGaussians given = copied;
    one.spoil(given);
    const std::string begin = std::string("qs_scene_gaussians: gaussians.") + one.sentence;
    EXPECT_EQ(test::sentence_of([&] { scene.gaussians(given); }).substr(0, begin.size()), begin);
    for (const float value : copied.means_of) EXPECT_EQ(value, -77.0f) << one.sentence;
  }
  char message[QS_MESSAGE_BYTES];
  const Copied<float> copied(5, 4);
  EXPECT_EQ(qs_scene_gaussians(nullptr, &copied, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_scene_gaussians: scene: is null");
  EXPECT_EQ(qs_scene_gaussians(scene.get(), nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_scene_gaussians: gaussians: is null");
}

TEST(LibraryGaussians, need_the_context) {
  auto context = std::make_unique<quadsplat::Context>(QS_BACKEND_CPU, 0, 1);
  quadsplat::Scene scene = context->wrap(test::gaussians_of(cloud_of(5, 0)));
  context.reset();
  const Copied<float> copied(5, 1);
  EXPECT_EQ(test::sentence_of([&] { scene.gaussians(copied); }),
            "qs_scene_gaussians: scene: its context was closed");
}

}  // namespace
}  // namespace qs
