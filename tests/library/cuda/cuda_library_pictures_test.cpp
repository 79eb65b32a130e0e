// SPDX-License-Identifier: MIT
// Scenes and pictures through the C interface with arrays in the memory of a GPU.
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <gmock/gmock.h>

#include "library/on_gpu.h"
#include "library/opened_scene.h"
#include "support/gpu.h"
#include "support/scenes.h"

namespace qs {
namespace {

using quadsplat::array_of;
using quadsplat::sized;
using test::gaussians_of;
using test::OnGpu;
using test::Results;
using testing::HasSubstr;

constexpr int kWidth = 45, kHeight = 37;

class CudaLibraryPictures : public test::GpuTest {
 protected:
  void SetUp() override {
    GpuTest::SetUp();
    if (IsSkipped()) return;
    context_.emplace(QS_BACKEND_CUDA, 0, 1);
    scene_.emplace(context_->wrap(gaussians_of(test::random_cloud(300, 2, 5))));
  }
  quadsplat::Context& context() { return *context_; }
  quadsplat::Scene& scene() { return *scene_; }

  const QsCamera camera = test::c_camera(test::front_camera(kWidth, kHeight));

 private:
  std::optional<quadsplat::Context> context_;
  std::optional<quadsplat::Scene> scene_;
};

std::array<QsArray*, 4> maps_of(QsPicture& picture) {
  return {&picture.color, &picture.alpha, &picture.depth, &picture.median_depth};
}

void place_maps(OnGpu& on_gpu, QsPicture& picture) {
  for (QsArray* const map : maps_of(picture)) on_gpu.place(*map);
}

TEST_F(CudaLibraryPictures, on_the_gpu_equal_pictures_on_the_host) {
  for (const std::uint32_t pipeline : {QS_PIPELINE_FAST, QS_PIPELINE_CLASSIC}) {
    QsSettings settings = quadsplat::default_settings();
    settings.pipeline = pipeline;
    settings.background[1] = 0.3f;
    const Results expected = test::rendered(scene(), camera, settings);
    Results found;
    QsPicture picture = test::picture_of(found, camera);
    OnGpu on_gpu;
    place_maps(on_gpu, picture);
    scene().render(camera, picture, settings);
    on_gpu.give_back();
    EXPECT_EQ(found.color, expected.color);
    EXPECT_EQ(found.alpha, expected.alpha);
    EXPECT_EQ(found.depth, expected.depth);
    EXPECT_EQ(found.median_depth, expected.median_depth);
    EXPECT_EQ(found.evaluated, expected.evaluated);
    EXPECT_EQ(found.pairs, expected.pairs);
    EXPECT_EQ(found.counts.tile_pairs, expected.counts.tile_pairs);
    EXPECT_GT(found.counts.tile_pairs, 0u);
  }
}

TEST_F(CudaLibraryPictures, through_lenses_stay_on_the_gpu) {
  QsCamera fisheye = camera;
  test::set_model(fisheye, "SIMPLE_FISHEYE", {14, 22, 18});
  Results expected;
  QsPicture on_host = test::picture_of(expected, fisheye);
  on_host.evaluated = on_host.pairs = on_host.used = QS_ABSENT;
  scene().render(fisheye, on_host);
  Results found;
  QsPicture picture = test::picture_of(found, fisheye);
  picture.evaluated = picture.pairs = picture.used = QS_ABSENT;
  OnGpu on_gpu;
  place_maps(on_gpu, picture);
  scene().render(fisheye, picture);
  on_gpu.give_back();
  EXPECT_EQ(found.color, expected.color);
  EXPECT_EQ(found.alpha, expected.alpha);
  EXPECT_EQ(found.depth, expected.depth);
  EXPECT_EQ(found.median_depth, expected.median_depth);
  EXPECT_EQ(found.counts.tile_pairs, expected.counts.tile_pairs);
  EXPECT_GT(*std::max_element(found.color.begin(), found.color.end()), 0.1f);
}

TEST_F(CudaLibraryPictures, have_any_strides_and_8_bits_there) {
  const std::vector<float> color = test::colors(scene(), camera);  // without counts, as below
  const Results expected = test::rendered(scene(), camera);
  // Two views in one call: planes of floats from the last row up, and 8 bits with gaps between
  // pixels.
  std::vector<float> planes(3 * kWidth * kHeight, -1);
  std::vector<std::uint8_t> bytes(4 * kWidth * kHeight, 77), alpha(kWidth * kHeight);
  QsPicture pictures[2] = {sized<QsPicture>(), sized<QsPicture>()};
  pictures[0].color = array_of(planes.data() + (kHeight - 1) * kWidth, {kHeight, kWidth, 3});
  pictures[0].color.strides[0] = -kWidth;
  pictures[0].color.strides[1] = 1;
  pictures[0].color.strides[2] = kWidth * kHeight;
  pictures[1].color = array_of(bytes.data(), {kHeight, kWidth, 3});
  pictures[1].color.strides[0] = 4 * kWidth;
  pictures[1].color.strides[1] = 4;
  pictures[1].alpha = array_of(alpha.data(), {kHeight, kWidth});
  OnGpu on_gpu;
  for (QsPicture& picture : pictures) place_maps(on_gpu, picture);
  const QsCamera cameras[2] = {camera, camera};
  quadsplat::check(qs_render, scene().get(), cameras, 2, nullptr, pictures);
  on_gpu.give_back();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int pixel = y * kWidth + x;
      for (int c = 0; c < 3; ++c) {
        const float value = color[static_cast<std::size_t>(3 * pixel + c)];
        EXPECT_EQ(
            planes[static_cast<std::size_t>(c * kWidth * kHeight + (kHeight - 1 - y) * kWidth + x)],
            value);
        EXPECT_EQ(bytes[static_cast<std::size_t>(4 * pixel + c)], to_8bit(value));
      }
      EXPECT_EQ(bytes[static_cast<std::size_t>(4 * pixel + 3)], 77) << "the gap";
      EXPECT_EQ(alpha[static_cast<std::size_t>(pixel)],
                to_8bit(expected.alpha[static_cast<std::size_t>(pixel)]));
    }
  }
}

TEST_F(CudaLibraryPictures, may_have_depths_alone) {
  const Results expected = test::rendered(scene(), camera);
  std::vector<float> depth(kWidth * kHeight);
  auto picture = sized<QsPicture>();
  picture.depth = array_of(depth.data(), {kHeight, kWidth});
  OnGpu on_gpu;
  place_maps(on_gpu, picture);
  scene().render(camera, picture);
  on_gpu.give_back();
  EXPECT_EQ(depth, expected.depth);
}

TEST_F(CudaLibraryPictures, are_refused_in_other_places) {
  Results found;
  const auto refusal = [&](const std::function<void(OnGpu&, QsPicture&)>& change,
                           quadsplat::Scene& drawn) {
    QsPicture picture = test::picture_of(found, camera);
    OnGpu on_gpu;
    change(on_gpu, picture);
    return test::sentence_of([&] { drawn.render(camera, picture); });
  };
  const auto of_color = [](OnGpu& on_gpu, QsPicture& picture) { on_gpu.place(picture.color); };
  EXPECT_EQ(refusal(of_color, scene()),
            "qs_render: pictures[0].alpha: is in host memory, but color is in the memory of GPU 0");
  const auto of_counts = [](OnGpu& on_gpu, QsPicture& picture) {
    place_maps(on_gpu, picture);
    on_gpu.place(picture.pairs);
  };
  EXPECT_EQ(refusal(of_counts, scene()),
            "qs_render: pictures[0].pairs: is in the memory of a GPU, but this array must be in "
            "host memory");
  const auto of_another = [](OnGpu& on_gpu, QsPicture& picture) {
    place_maps(on_gpu, picture);
    for (QsArray* const map : maps_of(picture)) map->device = 7;
  };
  EXPECT_EQ(refusal(of_another, scene()),
            "qs_render: pictures[0].color: is in the memory of GPU 7, but the context uses GPU 0");
  quadsplat::Context cpu = test::cpu();
  quadsplat::Scene on_host = cpu.wrap(gaussians_of(test::random_cloud(3, 0, 5)));
  EXPECT_THAT(
      refusal([](OnGpu& on_gpu, QsPicture& picture) { place_maps(on_gpu, picture); }, on_host),
      HasSubstr("color: is in the memory of GPU 0, but the context has the backend cpu"));
}

TEST_F(CudaLibraryPictures, of_gaussians_on_the_gpu_equal_those_of_the_host) {
  const GaussianCloud cloud = test::random_cloud(300, 2, 5);
  test::CloudArrays given = gaussians_of(cloud);
  // The means stand in reverse in rows of 5 numbers, which begin with another number.
  std::vector<float> rows(5 * cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      rows[5 * (cloud.size() - 1 - i) + 1 + static_cast<std::size_t>(axis)] =
          cloud.positions[i][axis];
  given.means.data = rows.data() + 5 * (cloud.size() - 1) + 1;
  given.means.strides[0] = -5;
  // The other coefficients are in an array of their own.
  given.rest = given.colors;
  given.rest.sizes[1] -= 1;
  given.rest.data = static_cast<float*>(given.rest.data) + given.rest.strides[1];
  given.colors.sizes[1] = 1;
  OnGpu on_gpu;
  for (QsArray* const array : {&given.means, &given.scales, &given.rotations, &given.opacities,
                               &given.colors, &given.rest})
    on_gpu.place(*array);
  quadsplat::Scene wrapped = context().wrap(given);
  EXPECT_EQ(test::colors(wrapped, camera), test::colors(scene(), camera));

  given.scales.memory = QS_MEMORY_HOST;
  EXPECT_EQ(
      test::sentence_of([&] { context().wrap(given); }),
      "qs_scene_wrap: gaussians.scales: is in host memory, but means is in the memory of GPU 0");
  given.scales.memory = QS_MEMORY_CUDA;
  quadsplat::Context cpu = test::cpu();
  EXPECT_THAT(test::sentence_of([&] { cpu.wrap(given); }),
              HasSubstr("means: is in the memory of GPU 0, but the context has the backend cpu"));
}

TEST_F(CudaLibraryPictures, of_no_gaussians_on_the_gpu_are_empty) {
  test::CloudArrays given = gaussians_of(GaussianCloud{});
  OnGpu on_gpu;
  for (QsArray* const array :
       {&given.means, &given.scales, &given.rotations, &given.opacities, &given.colors})
    on_gpu.place(*array);
  quadsplat::Scene empty = context().wrap(given);
  EXPECT_EQ(test::colors(empty, camera), std::vector<float>(3 * kWidth * kHeight, 0.0f));
}

}  // namespace
}  // namespace qs
