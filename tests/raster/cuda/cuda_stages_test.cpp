// SPDX-License-Identifier: MIT
// The stages of the differentiable rasterizer on the GPU: against the stages of the CPU.
#include <limits>

#include "support/error_of.h"
#include "support/gpu.h"
#include "support/gpu_stage_scenes.h"

namespace qs {
namespace {

using stages::DrawnView;
using stages::Rows;
using test::BoundaryValues;
using test::GpuArray;
using test::GpuBoundary;
using test::GpuScene;
using test::GpuStageFrame;
using test::off_centre_view;
using test::pool;
using test::stage_scene;
using test::StageScene;
using test::with_channels;

class CudaStages : public test::GpuTest {};

/// The lists of the CPU's frame as copy_lists() returns those of the GPU.
cuda::stages::ListCopies lists_of(const test::ProjectedFrame<float>& frame, std::size_t count) {
  const auto view = frame.view();
  cuda::stages::ListCopies lists;
  for (const std::uint64_t begin : frame.lists.begin)
    lists.begin.push_back(static_cast<std::uint32_t>(begin));
  lists.tile_counts.resize(count);
  for (std::size_t pair = 0; pair < view.pairs; ++pair) {
    lists.gaussians.push_back(view.gaussians[view.listed[pair]]);
    ++lists.tile_counts[lists.gaussians.back()];
  }
  lists.projected = frame.projected;
  return lists;
}

/// Projects on both sides, and expects equal lists, rows of the boundary and radii. Colours may
/// differ by rounding. Returns the number of pairs.
std::size_t expect_equal_projections(const DrawnView& view, const StageScene<float>& scene) {
  const std::size_t count = scene.size();
  test::ProjectedFrame<float> frame;
  BoundaryValues<float> expected(count);
  std::vector<std::int32_t> expected_radii(2 * count);
  project<float>(view, scene.inputs(), {pool()}, frame, expected.rows(),
                 Rows<std::int32_t>::packed(expected_radii.data(), 2));
  const GpuScene inputs(scene);
  const GpuBoundary boundary(count);
  const GpuArray<std::int32_t> radii(2 * count);
  GpuStageFrame on_gpu;
  on_gpu.project(view, inputs.inputs(), boundary.rows(),
                 Rows<std::int32_t>::packed(radii.data(), 2));
  const auto lists = copy_lists(on_gpu.frame, {});
  const auto expected_lists = lists_of(frame, count);
  EXPECT_EQ(lists.begin, expected_lists.begin);
  EXPECT_EQ(lists.gaussians, expected_lists.gaussians);
  EXPECT_EQ(lists.tile_counts, expected_lists.tile_counts);
  EXPECT_EQ(lists.projected, expected_lists.projected);
  EXPECT_EQ(radii.values(), expected_radii);
  const BoundaryValues<float> values = boundary.values();
  EXPECT_EQ(values.mean_px, expected.mean_px);
  EXPECT_EQ(values.conic, expected.conic);
  EXPECT_EQ(values.depth, expected.depth);
  EXPECT_EQ(values.opacity, expected.opacity);
  for (std::size_t k = 0; k < expected.color.size(); ++k)
    EXPECT_NEAR(values.color[k], expected.color[k], 1e-6f) << k;
  return expected_lists.gaussians.size();
}

TEST_F(CudaStages, list_and_project_as_the_cpu_in_every_mode) {
  const StageScene<float> scene = stage_scene<float>(500, 22);
  for (const CullMode mode : test::tiled_modes()) {
    for (const bool antialiased : {false, true}) {
      SCOPED_TRACE(testing::Message() << mode_name(mode) << (antialiased ? ", antialiased" : ""));
      DrawnView view = off_centre_view();
      view.mode = mode;
      view.rules.antialiased = antialiased;
      EXPECT_GT(expect_equal_projections(view, scene), 500u);
    }
  }
}

TEST_F(CudaStages, list_and_project_as_the_cpu_by_every_rule) {
  StageScene<float> scene = stage_scene<float>(300, 23);
  for (std::size_t k = 0; k < 40; ++k) scene.rotations[k] *= 1.5f;
  for (std::size_t i = 0; i < 40; ++i)
    scene.opacities[i] = 0.002f + 0.0001f * static_cast<float>(i);
  const auto expect_equal = [&](const char* what, const auto& change) {
    SCOPED_TRACE(what);
    DrawnView view = off_centre_view();
    change(view);
    EXPECT_GT(expect_equal_projections(view, scene), 0u);
  };
  expect_equal("planes", [](DrawnView& view) {
    view.rules.near_depth = 1.5;
    view.rules.far_depth = 3.5;
  });
  expect_equal("dilation and scale", [](DrawnView& view) {
    view.rules.dilation = 0.1;
    view.rules.splat_scale = 1.7;
  });
  expect_equal("floor of the compensation", [](DrawnView& view) {
    view.rules.antialiased = true;
    view.rules.compensation_floor = 0.3;
  });
  expect_equal("slopes", [](DrawnView& view) {
    view.rules.slopes = stages::SlopeBounds{{-0.2, -0.1}, {0.1, 0.3}};
  });
  expect_equal("lengths of rotations",
               [](DrawnView& view) { view.rules.normalises_rotations = false; });
  expect_equal("degree of colours", [](DrawnView& view) { view.sh_degree = 1; });
  for (const RadiusRule rule :
       {RadiusRule::inria, RadiusRule::gsplat_1_4, RadiusRule::gsplat_1_5}) {
    for (const double clip : {0.0, 6.0}) {
      expect_equal("radii", [&](DrawnView& view) {
        view.mode = default_mode();
        view.rules.radius_rule = rule;
        view.rules.radius_clip = clip;
      });
    }
  }
}

TEST_F(CudaStages, list_and_project_inputs_of_all_kinds_as_the_cpu) {
  StageScene<float> covariances = stage_scene<float>(300, 24);
  covariances.has_covariances = true;
  EXPECT_GT(expect_equal_projections(off_centre_view(), covariances), 300u);
  for (const int channels : {1, 3, 32}) {
    expect_equal_projections(off_centre_view(),
                             with_channels(stage_scene<float>(100, 24), channels));
  }
  EXPECT_EQ(expect_equal_projections(off_centre_view(), StageScene<float>()), 0u);
  DrawnView pixel = off_centre_view(1, 1);
  pixel.camera.center_px = {0, 0};
  EXPECT_GT(expect_equal_projections(pixel, stage_scene<float>(50, 26)), 0u);
}

// Bit patterns that no comparison orders, and the largest numbers.
TEST_F(CudaStages, do_not_project_numbers_that_are_not_finite) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity(),
                  kMax = std::numeric_limits<float>::max();
  for (const int kind : {0, 1, 2}) {
    StageScene<float> scene = stage_scene<float>(40, 25);
    if (kind == 2) scene = with_channels(scene, 4);
    scene.has_covariances = kind == 1;
    std::size_t next = 0;
    scene.for_each_array([&](const char*, int numbers, std::vector<float>& values) {
      for (const float bad : {kNan, kInf, -kInf, kMax, -kMax}) {
        values[next * static_cast<std::size_t>(numbers)] = bad;
        next = (next + 1) % 40;
      }
    });
    EXPECT_GT(expect_equal_projections(off_centre_view(), scene), 0u);
  }
}

TEST_F(CudaStages, read_and_write_arrays_with_strides_in_place) {
  const DrawnView view = off_centre_view();
  const StageScene<float> scene = stage_scene<float>(60, 27);
  const std::size_t count = scene.size();
  const GpuScene packed(scene);
  const GpuBoundary boundary(count);
  GpuStageFrame frame, other;
  frame.project(view, packed.inputs(), boundary.rows());
  // A row of the records: mean, scale, rotation, opacity; the coefficients of colour by channel.
  std::vector<float> records(11 * count), planes(48 * count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) records[11 * i + k] = scene.means[3 * i + k];
    for (std::size_t k = 0; k < 3; ++k) records[11 * i + 3 + k] = scene.scales[3 * i + k];
    for (std::size_t k = 0; k < 4; ++k) records[11 * i + 6 + k] = scene.rotations[4 * i + k];
    records[11 * i + 10] = scene.opacities[i];
    for (std::size_t k = 0; k < 16; ++k) {
      for (std::size_t c = 0; c < 3; ++c)
        planes[(16 * c + k) * count + i] = scene.sh[48 * i + 3 * k + c];
    }
  }
  const GpuArray<float> device_records(records), device_planes(planes);
  const auto stride = static_cast<std::ptrdiff_t>(count);
  stages::GaussianInputs<float> in = packed.inputs();
  float* const at = device_records.data();
  in.means = {at, 11, 1};
  in.scales = {at + 3, 11, 1};
  in.rotations = {at + 6, 11, 1};
  in.opacities = {at + 10, 11, 1};
  in.sh = {{device_planes.data(), 1, 16 * stride},
           {device_planes.data() + count, 1, 16 * stride},
           stride};
  const GpuArray<float> means(2 * count);
  const GpuArray<std::int32_t> radii(count);
  stages::Boundary<float> out;
  out.mean_px = {means.data(), 1, stride};
  other.project(view, in, out, {radii.data(), 1, 0});
  EXPECT_EQ(copy_lists(other.frame, {}).gaussians, copy_lists(frame.frame, {}).gaussians);
  const auto columns = means.values(), rows = boundary.values().mean_px;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(columns[i], rows[2 * i]);
    EXPECT_EQ(columns[count + i], rows[2 * i + 1]);
  }
}

}  // namespace
}  // namespace qs
