// SPDX-License-Identifier: MIT
// Footprints, tile lists and counts of the library are the renderer's.
#include <limits>
#include <string>

#include <fmt/format.h>

#include "library/opened_scene.h"
#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

template <class T>
std::vector<T> numbers_in(const QsArray& array) {
  const auto* data = static_cast<const T*>(array.data);
  return {data, data + array.sizes[0]};
}

float real(const QsArray& array, std::size_t i, int j = 0) {
  return static_cast<const float*>(
      array.data)[static_cast<std::int64_t>(i) * array.strides[0] + j * array.strides[1]];
}

void expect_equal(const QsLists& lists, const Frame& frame) {
  const Trace& trace = frame.trace;
  EXPECT_EQ(lists.tile_columns, frame.grid.columns);
  EXPECT_EQ(lists.tile_rows, frame.grid.rows);
  EXPECT_EQ(lists.tile_px, frame.grid.tile_px);
  EXPECT_EQ(numbers_in<std::uint32_t>(lists.gaussians), trace.gaussians);
  EXPECT_EQ(numbers_in<std::uint32_t>(lists.listed), trace.listed);
  EXPECT_EQ(numbers_in<std::uint64_t>(lists.tile_begin), trace.tile_begin);
  EXPECT_EQ(numbers_in<float>(lists.depths), trace.depths);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < trace.gaussians.size(); ++i) {
    const Footprint& footprint = trace.footprints[i];
    wrong += real(lists.opacities, i) != trace.splats[i].opacity;
    const glm::vec3 covariance{footprint.covariance.xx, footprint.covariance.xy,
                               footprint.covariance.yy};
    for (int c = 0; c < 3; ++c) {
      wrong += real(lists.covariances, i, c) != covariance[c];
      wrong += real(lists.conics, i, c) != footprint.conic[c];
      wrong += real(lists.colors, i, c) != trace.splats[i].color[c];
      if (c < 2) wrong += real(lists.means_px, i, c) != footprint.mean_px[c];
    }
  }
  EXPECT_EQ(wrong, 0u);
}

TEST(LibraryLists, are_the_renderers_in_every_mode_and_pipeline) {
  const GaussianCloud cloud = test::random_cloud(3000, 2, 3);
  const Camera view = test::front_camera(90, 70);
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud, {});
  Outputs outputs;
  outputs.trace = true;
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
  for (CullMode mode = 0; mode <= mode_count(); ++mode) {
    for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
      SCOPED_TRACE(std::string(mode_name(mode)) + kPipelineNames[static_cast<int>(pipeline)]);
      RenderSettings settings;
      settings.mode = mode;
      settings.pipeline = pipeline;
      const Frame& frame = renderer->render(view, settings, outputs);
      QsSettings given = QS_SETTINGS;
      given.cull = mode_name(mode);
      given.pipeline = pipeline == Pipeline::fast ? QS_PIPELINE_FAST : QS_PIPELINE_CLASSIC;
      expect_equal(scene.lists(test::c_camera(view), given), frame);
    }
  }
}

TEST(LibraryLists, have_the_numbers_of_the_caller_when_some_gaussians_are_not_drawn) {
  GaussianCloud cloud = test::random_cloud(500, 0, 3);
  const QsCamera camera = test::c_camera(test::front_camera(90, 70));
  quadsplat::Context context = test::cpu();
  quadsplat::Scene all = context.wrap(test::gaussians_of(cloud));
  const QsLists before = all.lists(camera);
  const auto visible = numbers_in<std::uint32_t>(before.gaussians);
  const auto listed = numbers_in<std::uint32_t>(before.listed);
  ASSERT_GT(visible.size(), 50u);
  const std::uint32_t dropped = visible[20];
  cloud.positions[dropped].y = std::numeric_limits<float>::quiet_NaN();
  quadsplat::Scene some = context.wrap(test::gaussians_of(cloud));
  EXPECT_EQ(some.facts().not_drawn, 1u);
  EXPECT_EQ(some.facts().gaussians, 500u);
  const QsLists after = some.lists(camera);
  std::vector<std::uint32_t> expected_visible, expected_listed;
  for (const std::uint32_t number : visible)
    if (number != dropped) expected_visible.push_back(number);
  for (const std::uint32_t number : listed)
    if (number != dropped) expected_listed.push_back(number);
  EXPECT_EQ(numbers_in<std::uint32_t>(after.gaussians), expected_visible);
  EXPECT_EQ(numbers_in<std::uint32_t>(after.listed), expected_listed);
}

TEST(LibraryLists, of_a_scene_without_gaussians_are_empty) {
  quadsplat::Context context = test::cpu();
  const GaussianCloud none;
  quadsplat::Scene scene = context.wrap(test::gaussians_of(none));
  const QsLists lists = scene.lists(test::c_camera(test::front_camera(40, 20)));
  EXPECT_EQ(lists.gaussians.sizes[0], 0);
  EXPECT_EQ(lists.listed.sizes[0], 0);
  EXPECT_EQ(numbers_in<std::uint64_t>(lists.tile_begin), std::vector<std::uint64_t>(7, 0));
}

TEST(LibraryLists, counts_of_modes_are_the_counts_of_their_frames) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const QsCamera camera = test::plush_camera(3, 120, 90);
  for (const std::uint32_t pipeline : {QS_PIPELINE_FAST, QS_PIPELINE_CLASSIC}) {
    QsSettings settings = QS_SETTINGS;
    settings.pipeline = pipeline;
    const std::vector<QsModeCounts> counts = scene.count_modes(camera, settings);
    ASSERT_EQ(counts.size(), static_cast<std::size_t>(culler_count()));
    for (const QsModeCounts& count : counts) {
      settings.cull = count.name;
      const QsCounts frame = test::rendered(scene, camera, settings).counts;
      EXPECT_EQ(count.tile_pairs, frame.tile_pairs) << count.name;
      EXPECT_EQ(count.visible, frame.visible) << count.name;
      auto mode = quadsplat::sized<QsMode>();
      quadsplat::check(qs_mode, count.mode, &mode, nullptr);
      EXPECT_STREQ(mode.name, count.name);
    }
  }
}

TEST(LibraryLists, counts_of_modes_are_written_up_to_the_capacity) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(test::random_cloud(100, 0, 3)));
  const QsCamera camera = test::c_camera(test::front_camera(40, 20));
  std::vector<QsModeCounts> counts(3, quadsplat::sized<QsModeCounts>());
  std::uint64_t count = 0;
  quadsplat::check(qs_count_modes, scene.get(), &camera, nullptr, counts.data(), std::uint64_t{2},
                   &count);
  EXPECT_EQ(count, static_cast<std::uint64_t>(culler_count()));
  EXPECT_NE(counts[1].name, nullptr);
  EXPECT_EQ(counts[2].name, nullptr);
}

TEST(LibraryModes, are_the_table_of_the_program) {
  std::uint32_t count = 0;
  auto mode = quadsplat::sized<QsMode>();
  quadsplat::check(qs_mode, 0u, &mode, &count);
  EXPECT_STREQ(mode.name, "reference");
  ASSERT_EQ(count, static_cast<std::uint32_t>(mode_count()) + 1);
  for (std::uint32_t number = 0; number < count; ++number) {
    quadsplat::check(qs_mode, number, &mode, nullptr);
    const CullerRow& row = row_of(static_cast<CullMode>(number));
    EXPECT_STREQ(mode.name, row.name);
    EXPECT_STREQ(mode.summary, row.summary);
    EXPECT_EQ(mode.is_peer == 1, row.family == CullerFamily::peers);
    EXPECT_EQ(mode.is_lossless == 1, row.lossless);
    EXPECT_EQ(mode.keeps_faint == 1, row.keeps_faint);
  }
  EXPECT_EQ(test::sentence_of([&] { quadsplat::check(qs_mode, count, &mode, nullptr); }),
            fmt::format("qs_mode: number: {} is not below {}", count, count));
}

}  // namespace
}  // namespace qs
