// SPDX-License-Identifier: MIT
// The parts of a trainer through the C interface with arrays in the memory of a GPU.
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "library/on_gpu.h"
#include "library/opened_scene.h"
#include "raster/scene/image.h"
#include "support/gpu.h"

namespace qs {
namespace {

using quadsplat::array_of;
using quadsplat::check;
using quadsplat::sized;
using test::OnGpu;

std::vector<float> random_numbers(std::size_t count, unsigned seed, float low = -0.2f,
                                  float high = 1.2f) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(low, high);
  std::vector<float> numbers(count);
  for (float& number : numbers) number = uniform(random);
  return numbers;
}

class CudaLibraryParts : public test::GpuTest {
 protected:
  static quadsplat::Context gpu() { return quadsplat::Context(QS_BACKEND_CUDA, 0, 1); }
};

/// The results of both functions for two batches of pictures.
struct Compared {
  std::vector<float> ssim = {-1}, l1 = {-1}, by_a;
};

struct Batch {
  std::int64_t pictures, channels, height, width;
  bool channels_last = false;  ///< the channels of a pixel side by side

  std::int64_t size() const { return pictures * channels * height * width; }
  QsArray array(std::vector<float>& values) const {
    QsArray made = array_of(values.data(), {pictures, channels, height, width});
    if (channels_last) {
      made.strides[1] = 1;
      made.strides[2] = width * channels;
      made.strides[3] = channels;
    }
    return made;
  }
};

Compared compared(quadsplat::Context& context, const Batch& batch, std::uint32_t border,
                  bool with_l1, OnGpu* on_gpu) {
  const auto count = static_cast<std::size_t>(batch.size());
  std::vector<float> a = random_numbers(count, 1), b = random_numbers(count, 2), terms(3 * count);
  a[count / 2] = b[count / 2];
  std::vector<float> by_ssim = {-0.7f}, by_l1 = {0.3f};
  Compared found;
  found.by_a.assign(count, -9);
  auto given = sized<QsSimilarity>();
  given.border = border;
  given.a = batch.array(a);
  given.b = batch.array(b);
  given.ssim = array_of(found.ssim.data(), {1});
  given.by_ssim = array_of(by_ssim.data(), {1});
  given.by_a = batch.array(found.by_a);
  given.terms =
      array_of(terms.data(), {3, batch.pictures, batch.channels, batch.height * batch.width});
  if (with_l1) {
    given.l1 = array_of(found.l1.data(), {1});
    given.by_l1 = array_of(by_l1.data(), {1});
  }
  if (on_gpu != nullptr) {
    for (QsArray* const array : {&given.a, &given.b, &given.ssim, &given.l1, &given.terms,
                                 &given.by_ssim, &given.by_l1, &given.by_a})
      on_gpu->place(*array);
    given.temporary = on_gpu->temporary();
  }
  check(qs_similarity, context.get(), &given);
  check(qs_similarity_backward, context.get(), &given);
  if (on_gpu != nullptr) on_gpu->give_back();
  return found;
}

TEST_F(CudaLibraryParts, similarity_has_the_derivatives_of_the_cpu_to_the_bit) {
  quadsplat::Context context = gpu(), cpu = test::cpu(1);
  for (const Batch& batch : {Batch{1, 1, 1, 1}, Batch{1, 3, 40, 53}, Batch{2, 3, 17, 49, true},
                             Batch{1, 1, 11, 130}, Batch{3, 2, 33, 12, true}}) {
    for (const std::uint32_t border : {QS_BORDER_ZEROS, QS_BORDER_CROP}) {
      if (border == QS_BORDER_CROP && std::min(batch.width, batch.height) < 11) continue;
      for (const bool with_l1 : {false, true}) {
        const Compared expected = compared(cpu, batch, border, with_l1, nullptr);
        OnGpu on_gpu;
        on_gpu.gives_temporary = with_l1;
        const Compared found = compared(context, batch, border, with_l1, &on_gpu);
        EXPECT_EQ(found.by_a, expected.by_a);
        EXPECT_NEAR(found.ssim[0], expected.ssim[0], 1e-6);
        EXPECT_NEAR(found.l1[0], expected.l1[0], 1e-6);
        OnGpu again;
        EXPECT_EQ(compared(context, batch, border, with_l1, &again).ssim, found.ssim);
      }
    }
  }
}

TEST_F(CudaLibraryParts, similarity_on_a_gpu_has_sentences) {
  quadsplat::Context context = gpu();
  std::vector<float> a(48), number(1);
  std::vector<double> doubles(48);
  auto given = sized<QsSimilarity>();
  OnGpu on_gpu;
  const auto refusal = [&](const auto& change) {
    given.a = given.b = given.by_a = array_of(a.data(), {1, 3, 4, 4});
    given.ssim = given.by_ssim = array_of(number.data(), {1});
    for (QsArray* const array : {&given.a, &given.b, &given.by_a, &given.ssim, &given.by_ssim})
      on_gpu.place(*array);
    change();
    return test::sentence_of([&] {
      check(qs_similarity, context.get(), &given);
      check(qs_similarity_backward, context.get(), &given);
    });
  };
  EXPECT_EQ(refusal([&] { given.ssim = array_of(number.data(), {1}); }),
            "qs_similarity: compared.ssim: is in host memory, but a is in the memory of GPU 0");
  EXPECT_EQ(refusal([] {}),
            "qs_similarity_backward: compared.terms: is absent: it needs 4 dimensions");
  EXPECT_EQ(refusal([&] {
              given.a = given.b = array_of(doubles.data(), {1, 3, 4, 4});
              on_gpu.place(given.a);
              on_gpu.place(given.b);
            }),
            "qs_similarity: compared.a: has elements of float64: a GPU takes QS_FLOAT32");
}

/// Matrices of a camera, world to view x -> R x + t.
struct Matrices {
  std::vector<float> view = {0.8f, 0, -0.6f, 1, 0, 1, 0, 2, 0.6f, 0, 0.8f, 3, 0, 0, 0, 1};
  std::vector<float> lens = {50, 0, 31, 0, 40, 20, 0, 0, 1};
  std::vector<float> position = {4, 5, 6};
  double at[3] = {};

  /// As INRIA's trainer has them, transposed, with the principal point of `lens`.
  QsMatrices clip(std::vector<float>& whole, int width, int height) {
    QsMatrices given = as_given(whole.data(), {4, 4});
    given.is_clip = 1;
    const float size[] = {static_cast<float>(width), static_cast<float>(height)};
    float perspective[4][4] = {};  // rows
    for (int axis = 0; axis < 2; ++axis) {
      const float focal = lens[static_cast<std::size_t>(4 * axis)];
      const float center = lens[static_cast<std::size_t>(3 * axis + 2)];  // centres at halves
      perspective[axis][axis] = 2 * focal / size[axis];
      perspective[axis][2] = 2 * center / size[axis] - 1;
      given.half_fov[axis] = static_cast<double>(size[axis] / (2 * focal));
    }
    perspective[2][2] = 1.01f;
    perspective[2][3] = -0.01f;
    perspective[3][2] = 1;
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t column = 0; column < 4; ++column)
        for (std::size_t k = 0; k < 4; ++k)
          whole[4 * column + row] += perspective[row][k] * view[4 * k + column];
    std::swap(given.lens.strides[0], given.lens.strides[1]);
    return given;
  }
  QsMatrices as_given(float* of_lens, std::initializer_list<std::int64_t> sizes) {
    auto given = sized<QsMatrices>();
    given.view = array_of(view.data(), {4, 4});
    given.lens = array_of(of_lens, sizes);
    given.position = array_of(position.data(), {3});
    given.at = at;
    return given;
  }
};

TEST_F(CudaLibraryParts, cameras_come_from_matrices_in_any_memory) {
  quadsplat::Context context = gpu();
  for (const bool is_clip : {false, true}) {
    for (const bool is_on_gpu : {false, true}) {
      Matrices matrices;
      std::vector<float> whole(16, 0.0f);
      QsMatrices given =
          is_clip ? matrices.clip(whole, 60, 44) : matrices.as_given(matrices.lens.data(), {3, 3});
      OnGpu on_gpu;
      if (is_on_gpu)
        for (QsArray* const array : {&given.view, &given.lens, &given.position})
          on_gpu.place(*array);
      auto camera = sized<QsCamera>();
      camera.width = 60;
      camera.height = 44;
      camera.near_depth = 0.2;
      check(qs_camera_of_matrices, context.get(), &given, &camera);
      EXPECT_NEAR(camera.focal_px[0], 50, 1e-4);
      EXPECT_NEAR(camera.focal_px[1], 40, 1e-4);
      EXPECT_NEAR(camera.center_px[0], 30.5, 1e-4);
      EXPECT_NEAR(camera.center_px[1], 19.5, 1e-4);
      EXPECT_FLOAT_EQ(static_cast<float>(camera.view_from_world[2]), -0.6f);
      EXPECT_EQ(camera.view_from_world[11], 3);
      EXPECT_EQ(matrices.at[2], 6);
      if (is_clip)
        given.half_fov[0] *= 1.1;
      else
        given.lens.sizes[0] = 2;
      EXPECT_EQ(
          test::sentence_of([&] { check(qs_camera_of_matrices, context.get(), &given, &camera); }),
          is_clip ? "qs_camera_of_matrices: matrices.lens: is not the view times a "
                    "perspective projection with the given fields of view"
                  : "qs_camera_of_matrices: matrices.lens: has 2 x 3 elements instead of 3 x "
                    "3");
    }
  }
}

constexpr std::int64_t kCount = 600;

TEST_F(CudaLibraryParts, covariances_and_noise_have_the_bits_of_the_cpu) {
  quadsplat::Context context = gpu(), cpu = test::cpu(1);
  std::vector<float> rotations = random_numbers(4 * kCount, 3),
                     scales = random_numbers(3 * kCount, 4);
  std::vector<float> logits = random_numbers(kCount, 5, -8, 3);
  std::vector<float> normals = random_numbers(3 * kCount, 6, -2, 2);
  logits[7] = NAN;
  for (int dimensions : {2, 3}) {
    std::vector<std::vector<float>> found;
    for (quadsplat::Context* const used : {&cpu, &context}) {
      std::vector<float> covariances(9 * kCount, -1), means = random_numbers(3 * kCount, 7);
      QsArray of_rotations = array_of(rotations.data(), {kCount, 4});
      QsArray of_scales = array_of(scales.data(), {kCount, 3});
      QsArray of_covariances = dimensions == 2 ? array_of(covariances.data(), {kCount, 6})
                                               : array_of(covariances.data(), {kCount, 3, 3});
      auto noise = sized<QsNoise>();
      noise.factor = 0.3;
      noise.slope = 100;
      noise.middle = 0.005;
      noise.means = array_of(means.data(), {kCount, 3});
      noise.log_scales = of_scales;
      noise.rotations = of_rotations;
      noise.opacity_logits = array_of(logits.data(), {kCount});
      noise.normals = array_of(normals.data(), {kCount, 3});
      OnGpu on_gpu;
      if (used == &context)
        for (QsArray* const array :
             {&of_rotations, &of_scales, &of_covariances, &noise.means, &noise.log_scales,
              &noise.rotations, &noise.opacity_logits, &noise.normals})
          on_gpu.place(*array);
      check(qs_context_stream, used->get(), nullptr);
      check(qs_covariances, used->get(), &of_rotations, &of_scales, &of_covariances);
      check(qs_noise, used->get(), &noise);
      on_gpu.give_back();
      found.push_back(covariances);
      found.push_back(means);
    }
    EXPECT_EQ(found[0], found[2]);
    EXPECT_EQ(found[1], found[3]);
    const std::vector<float> before = random_numbers(3 * kCount, 7);
    EXPECT_NE(found[1], before);
    EXPECT_EQ(found[1][21], before[21]) << "the noise is not finite";
    EXPECT_EQ(found[0][8 * kCount] == -1, dimensions == 2);
  }
}

TEST_F(CudaLibraryParts, views_are_added_where_both_radii_are_above_0) {
  quadsplat::Context context = gpu(), cpu = test::cpu(1);
  std::vector<float> gradients = random_numbers(2 * kCount, 21);
  std::vector<std::int32_t> radii(2 * kCount, 3);
  radii[2] = 0, radii[5] = 0, radii[6] = -1;
  std::vector<std::vector<float>> found;
  for (quadsplat::Context* const used : {&cpu, &context}) {
    std::vector<float> lengths(kCount, 0.5f), views(kCount, 2);
    QsArray arrays[] = {array_of(gradients.data(), {kCount, 2}),
                        array_of(radii.data(), {kCount, 2}), array_of(lengths.data(), {kCount}),
                        array_of(views.data(), {kCount})};
    OnGpu on_gpu;
    if (used == &context)
      for (QsArray& array : arrays) on_gpu.place(array);
    check(qs_context_stream, used->get(), nullptr);
    check(qs_add_view, used->get(), &arrays[0], &arrays[1], 400.0, 300.0, &arrays[2], &arrays[3]);
    on_gpu.give_back();
    found.push_back(lengths);
    found.push_back(views);
  }
  EXPECT_EQ(found[1], found[3]);
  for (std::size_t i = 0; i < kCount; ++i) {
    const bool is_seen = i < 1 || i > 3;
    EXPECT_EQ(found[1][i], is_seen ? 3 : 2);
    const double length = std::hypot(400.0 * gradients[2 * i], 300.0 * gradients[2 * i + 1]);
    EXPECT_NEAR(found[0][i], 0.5 + (is_seen ? length : 0), 1e-6 * (1 + length));
    EXPECT_FLOAT_EQ(found[0][i], found[2][i]);
  }
}

TEST_F(CudaLibraryParts, neighbours_have_the_bits_of_the_cpu) {
  quadsplat::Context context = gpu(), cpu = test::cpu(1);
  const auto cloud = [](std::size_t count, bool is_far) {
    std::vector<float> points = random_numbers(3 * count, 10);
    for (std::size_t i = 0; i + 2 < points.size() && is_far; i += 7) points[i] *= 1e6f;
    for (std::size_t i = 0; i < count / 5; ++i)  // copies
      std::copy_n(&points[3 * (i + count / 2)], 3, &points[3 * i]);
    if (count > 9) points[16] = NAN, points[25] = INFINITY;
    return points;
  };
  for (const std::size_t count : {0, 1, 2, 3, 4, 5, 63, 64, 65, 130, 5000}) {
    for (const bool is_far : {false, true}) {
      std::vector<float> points = cloud(count, is_far), packed(count, -1);
      std::vector<double> expected(count), found(count, -1);
      const auto rows = static_cast<std::int64_t>(count);
      QsArray of_points = array_of(points.data(), {rows, 3});
      const QsArray of_expected = array_of(expected.data(), {rows});
      check(qs_neighbours, cpu.get(), &of_points, &of_expected);
      QsArray of_found = array_of(found.data(), {rows}),
              of_packed = array_of(packed.data(), {rows});
      OnGpu on_gpu;
      for (QsArray* const array : {&of_points, &of_found, &of_packed}) on_gpu.place(*array);
      check(qs_neighbours, context.get(), &of_points, &of_found);
      check(qs_neighbours, context.get(), &of_points, &of_packed);
      on_gpu.give_back();
      for (std::size_t i = 0; i < count; ++i) {
        const bool both = std::isnan(expected[i]) && std::isnan(found[i]);
        EXPECT_TRUE(both || found[i] == expected[i]) << count << " " << i;
        EXPECT_TRUE(both || packed[i] == static_cast<float>(expected[i]));
      }
    }
  }
  std::vector<float> same(3 * 300, 2.5f);  // one place
  std::vector<float> zeros(300, -1);
  QsArray of_same = array_of(same.data(), {300, 3}), of_zeros = array_of(zeros.data(), {300});
  OnGpu on_gpu;
  on_gpu.place(of_same);
  on_gpu.place(of_zeros);
  check(qs_neighbours, context.get(), &of_same, &of_zeros);
  on_gpu.give_back();
  EXPECT_EQ(zeros, std::vector<float>(300, 0));
}

TEST_F(CudaLibraryParts, relocation_is_the_one_of_the_cpu) {
  quadsplat::Context context = gpu(), cpu = test::cpu(1);
  std::vector<float> opacities = random_numbers(kCount, 8), scales = random_numbers(3 * kCount, 9);
  std::vector<std::int64_t> counts;
  for (std::int64_t i = 0; i < kCount; ++i) counts.push_back(i % 70 - 3);
  std::vector<std::vector<float>> found;
  for (quadsplat::Context* const used : {&cpu, &context}) {
    std::vector<float> new_opacities(kCount), new_scales(3 * kCount);
    QsArray arrays[] = {array_of(opacities.data(), {kCount}), array_of(scales.data(), {kCount, 3}),
                        array_of(counts.data(), {kCount}), array_of(new_opacities.data(), {kCount}),
                        array_of(new_scales.data(), {kCount, 3})};
    OnGpu on_gpu;
    if (used == &context)
      for (QsArray& array : arrays) on_gpu.place(array);
    check(qs_relocate, used->get(), &arrays[0], &arrays[1], &arrays[2], &arrays[3], &arrays[4]);
    on_gpu.give_back();
    found.push_back(new_opacities);
    found.push_back(new_scales);
  }
  EXPECT_THAT(found[2], testing::Pointwise(testing::FloatNear(1e-6f), found[0]));
  EXPECT_THAT(found[3], testing::Pointwise(testing::FloatNear(1e-3f), found[1]));
  EXPECT_NE(found[0], opacities);
}

/// Two pictures of height x width x 3, the values of the second as bytes, floats or doubles, and a
/// mask.
struct ComparedPair {
  std::int64_t height, width;
  std::vector<float> a, b;
  std::vector<double> planes;
  std::vector<std::uint8_t> bytes, mask;

  ComparedPair(std::int64_t height_, std::int64_t width_)
      : height(height_),
        width(width_),
        a(random_numbers(static_cast<std::size_t>(3 * height_ * width_), 1)),
        b(random_numbers(a.size(), 2)),
        planes(b.begin(), b.end()),
        mask(a.size() / 3) {
    a[0] = std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = 0; i < a.size(); ++i) b[i] = 0.7f * a[i] + 0.3f * b[i];
    for (const float value : b) bytes.push_back(to_8bit(value));
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 3 == 0 ? 0 : 255;
  }

  /// `type` of the second picture; QS_FLOAT64: a plane per channel.
  QsComparison compared(quadsplat::Context& context, std::uint32_t type, QsComparison asked,
                        OnGpu* on_gpu) {
    QsArray first = array_of(a.data(), {height, width, 3});
    QsArray second = type == QS_UINT8     ? array_of(bytes.data(), {height, width, 3})
                     : type == QS_FLOAT32 ? array_of(b.data(), {height, width, 3})
                                          : quadsplat::planes_of(planes.data(), height, width);
    if (on_gpu != nullptr)
      for (QsArray* const array : {&first, &second, &asked.mask}) on_gpu->place(*array);
    asked = context.compare(first, second, asked);
    if (on_gpu != nullptr) on_gpu->give_back();
    return asked;
  }
};

void expect_near(double found, double expected) {
  EXPECT_NEAR(found, expected, 1e-9 * std::abs(expected));
}

TEST_F(CudaLibraryParts, pictures_have_the_metrics_of_the_cpu) {
  quadsplat::Context context = gpu(), cpu = test::cpu(1);
  for (const auto& [height, width] : {std::pair{1, 1}, {23, 41}, {16, 32}, {11, 70}}) {
    ComparedPair pair(height, width);
    for (const std::uint32_t type : {QS_FLOAT32, QS_FLOAT64, QS_UINT8}) {
      for (const std::uint32_t border : {QS_BORDER_ZEROS, QS_BORDER_CROP}) {
        if (border == QS_BORDER_CROP && height < 11) continue;
        for (const bool masked : {false, true}) {
          auto asked = sized<QsComparison>();
          asked.ssim_border = border;
          asked.metrics = QS_METRIC_PSNR | QS_METRIC_SSIM;
          if (!masked) asked.metrics |= QS_METRIC_PSNR_8BIT | QS_METRIC_FLIP;
          if (masked && height > 1) asked.mask = array_of(pair.mask.data(), {height, width});
          OnGpu on_gpu, again;
          const QsComparison expected = pair.compared(cpu, type, asked, nullptr);
          const QsComparison found = pair.compared(context, type, asked, &on_gpu);
          expect_near(found.psnr, expected.psnr);
          expect_near(found.ssim, expected.ssim);
          EXPECT_EQ(found.psnr_8bit, expected.psnr_8bit);
          EXPECT_EQ(found.flip, expected.flip);
          EXPECT_EQ(pair.compared(context, type, asked, &again).ssim, found.ssim);
        }
      }
    }
    std::vector<float> values = pair.a;
    QsArray same = array_of(values.data(), {height, width, 3});
    OnGpu on_gpu;
    on_gpu.place(same);
    auto asked = sized<QsComparison>();
    asked.metrics = QS_METRIC_PSNR | QS_METRIC_SSIM;
    asked = context.compare(same, same, asked);
    EXPECT_EQ(asked.psnr, std::numeric_limits<double>::infinity());
    EXPECT_EQ(asked.ssim, 1);
    EXPECT_EQ(asked.psnr_8bit, 0) << "was not asked for";
  }
}

TEST_F(CudaLibraryParts, pictures_are_compared_in_one_memory) {
  quadsplat::Context context = gpu(), cpu = test::cpu(1);
  ComparedPair pair(12, 13);
  QsArray a = array_of(pair.a.data(), {12, 13, 3}), b = array_of(pair.b.data(), {12, 13, 3});
  auto asked = sized<QsComparison>();
  asked.metrics = QS_METRIC_PSNR;
  OnGpu on_gpu;
  const auto refusal = [&](quadsplat::Context& used) {
    return test::sentence_of([&] { used.compare(a, b, asked); });
  };
  on_gpu.place(a);
  EXPECT_EQ(refusal(context), "qs_compare: b: is in host memory, but a is in the memory of GPU 0");
  on_gpu.place(b);
  asked.mask = array_of(pair.mask.data(), {12, 13});
  EXPECT_EQ(refusal(context),
            "qs_compare: comparison.mask: is in host memory, but a is in the memory of GPU 0");
  asked.mask = {};
  EXPECT_EQ(refusal(cpu),
            "qs_compare: a: is in the memory of GPU 0, but the context has the backend cpu: open "
            "one with QS_BACKEND_CUDA");
}

}  // namespace
}  // namespace qs
