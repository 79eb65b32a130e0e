// SPDX-License-Identifier: MIT
// Compares the CUDA backend on real scenes with the CPU backend on every camera, and with the
// recorded results of published implementations (golden_test.cpp does the same for the CPU).
#include <fstream>
#include <map>

#include <nlohmann/json.hpp>

#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "io/scene/reader.h"
#include "support/gpu.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

using Json = nlohmann::json;

/// Both renderers with the same scene, which is read only once per process.
struct Pair {
  std::unique_ptr<Renderer> cpu, gpu;

  static Pair& of(const std::string& scene) {
    static std::map<std::string, Pair> pairs;
    Pair& pair = pairs[scene];
    if (!pair.gpu) {
      const GaussianCloud cloud = test::read_scene(test::shared_path(scene)).cloud;
      pair.cpu = make_renderer(Backend::cpu, test::pool());
      pair.gpu = make_renderer(Backend::cuda, test::pool());
      pair.cpu->upload(cloud, {});
      pair.gpu->upload(cloud, {});
    }
    return pair;
  }
};

std::vector<Camera> cameras_of(const std::string& set) {
  const auto own = test::shared_path("golden/" + set + ".cameras.json");
  return read_cameras(
      std::filesystem::exists(own) ? own : test::shared_path("scenes/plush/cameras.json"));
}

constexpr const char* kTooLarge = "real scenes and their images are too large for the emulator";

class CudaScenes : public test::PipelineTest {
 protected:
  void SetUp() override {
    GpuTest::SetUp();
    QS_NEEDS_REAL_GPU(kTooLarge);
  }
};

class CudaSceneSets : public test::GpuTest, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    GpuTest::SetUp();
    QS_NEEDS_REAL_GPU(kTooLarge);
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaScenes, test::kPipelines, test::name_of_pipeline);

INSTANTIATE_TEST_SUITE_P(Golden, CudaSceneSets,
                         testing::Values("plush", "plush_big", "plush_big_4k"),
                         [](const auto& set) { return std::string(set.param); });

/// Published counts of one camera, by our names of the modes.
std::map<std::string, double> published_counts(const Json& pairs, std::size_t k) {
  return {{"3dgs", pairs["official"][k].get<double>()},
          {"adr", pairs["adr"][k].get<double>()},
          {"quadbox", pairs["quadbox"][k].get<double>()}};
}

TEST_P(CudaSceneSets, equal_the_cpu_and_the_published_counts_on_every_camera) {
  QS_NEEDS_SHARED("golden/pairs.json");
  const Json set = Json::parse(std::ifstream(test::shared_path("golden/pairs.json")))[GetParam()];
  Pair& renderers = Pair::of(set["file"].get<std::string>());
  const std::vector<Camera> cameras = cameras_of(GetParam());
  Outputs outputs;
  outputs.trace = true;
  for (std::size_t k = 0; k < set["cameras"].size(); ++k) {
    const Camera& camera = cameras.at(set["cameras"][k].get<std::size_t>());
    std::map<std::string, std::uint64_t> counts;
    for (const CullMode mode : test::tiled_modes()) {
      const std::string name = mode_name(mode);
      SCOPED_TRACE(name + ", camera " + set["cameras"][k].dump());
      RenderSettings settings;
      settings.mode = mode;
      const Frame& a = renderers.cpu->render(camera, settings, outputs);
      for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
        settings.pipeline = pipeline;
        SCOPED_TRACE(kPipelineNames[static_cast<int>(pipeline)]);
        const Frame& b = renderers.gpu->render(camera, settings, outputs);
        EXPECT_EQ(test::difference(b.trace, a.trace), "");
        test::expect_same_image(b.color, a.color);
        counts[name] = b.stats.tile_pairs;
      }
    }
    for (const auto& [name, published] : published_counts(set["pairs"], k)) {
      EXPECT_NEAR(static_cast<double>(counts[name]), published, 5e-4 * published) << name;
    }
    if (set["pairs"].contains("accutile")) {
      EXPECT_LE(counts["exact"], set["pairs"]["accutile"][k].get<std::uint64_t>());
    }
  }
}

TEST_P(CudaScenes, draw_the_published_images) {
  for (const auto& [scene, index] : {std::pair<std::string, std::size_t>{"plush", 0},
                                     {"plush", 32},
                                     {"plush", 64},
                                     {"plush_big", 0},
                                     {"plush_big", 88}}) {
    const std::string file = "golden/" + scene + "_camera" + std::to_string(index) + "_3dgs.png";
    QS_NEEDS_SHARED(file);
    const Image published = read_image(test::shared_path(file));
    const Camera camera = cameras_of(scene).at(index);
    Renderer& gpu = *Pair::of("scenes/" + scene + ".spz").gpu;
    for (const auto& [mode, decibels] : {std::pair{"3dgs", 80.0}, {"quadbox", 70.0}}) {
      RenderSettings settings = settings_of_pipeline();
      settings.mode = find_culler(mode);
      EXPECT_GE(psnr_8bit(gpu.render(camera, settings).color, published), decibels)
          << file << ", " << mode;
    }
  }
}

TEST_P(CudaScenes, are_within_80_db_of_the_reference_between_the_steps_of_storage_too) {
  QS_NEEDS_SHARED("scenes/plush.spz");
  const GaussianCloud noisy =
      test::with_storage_noise(test::read_scene(test::shared_path("scenes/plush.spz")).cloud, 2026);
  const auto cpu = renderer_of(Backend::cpu, noisy), gpu = renderer_of(Backend::cuda, noisy);
  double worst = 1000;
  for (const std::size_t index : {0u, 16u, 32u, 48u, 64u, 88u}) {
    const Camera camera = cameras_of("plush").at(index);
    RenderSettings settings = settings_of_pipeline();
    settings.mode = kReferenceMode;
    const Image reference = cpu->render(camera, settings).color;
    for (const char* mode : {"exact", "quadbox"}) {
      settings.mode = find_culler(mode);
      const double decibels = psnr_8bit(gpu->render(camera, settings).color, reference);
      EXPECT_GE(decibels, 80.0) << mode << ", camera " << index;
      worst = std::min(worst, decibels);
    }
  }
  RecordProperty("worst_psnr_db", std::to_string(worst));
}

// 3840x2160 from camera 0 with every Gaussian scaled by 4.
TEST_P(CudaScenes, of_more_than_a_hundred_million_pairs_are_drawn) {
  QS_NEEDS_SHARED("scenes/plush_big.spz");
  Renderer& gpu = *Pair::of("scenes/plush_big.spz").gpu;
  const Camera camera = cameras_of("plush_big").at(0).resized(3840, 2160);
  RenderSettings settings = settings_of_pipeline();
  settings.mode = find_culler("adr");
  settings.splat_scale = 4;
  const Frame wide = gpu.render(camera, settings);
  EXPECT_GT(wide.stats.tile_pairs, 100'000'000u);
  RecordProperty("pairs", std::to_string(wide.stats.tile_pairs));
  RecordProperty("frame_ms", std::to_string(gpu.render(camera, settings).stats.frame_ms));
  settings.mode = find_culler("exact");
  EXPECT_EQ(gpu.render(camera, settings).color.values, wide.color.values);
}

TEST_P(CudaScenes, use_the_pairs_that_the_cpu_uses_and_waste_least_in_mode_exact) {
  QS_NEEDS_SHARED("scenes/plush.spz");
  Pair& renderers = Pair::of("scenes/plush.spz");
  const Camera camera = cameras_of("plush").at(0);
  Outputs outputs;
  outputs.color = false;
  outputs.used = true;
  std::map<std::string, std::uint64_t> wasted;
  for (const CullMode mode : test::tiled_modes()) {
    SCOPED_TRACE(mode_name(mode));
    RenderSettings settings = settings_of_pipeline();
    settings.mode = mode;
    const RenderStats a = renderers.cpu->render(camera, settings, outputs).stats;
    const RenderStats b = renderers.gpu->render(camera, settings, outputs).stats;
    wasted[mode_name(mode)] = b.tile_pairs - *b.used_pairs;
    const auto of_cpu = static_cast<double>(a.tile_pairs - *a.used_pairs);
    EXPECT_NEAR(static_cast<double>(b.tile_pairs - *b.used_pairs), of_cpu, 1e-4 * of_cpu);
  }
  for (const auto& [name, count] : wasted) {
    EXPECT_TRUE(name == "exact" || wasted["exact"] < count) << name;
  }
}

TEST_P(CudaScenes, are_within_80_db_of_the_reference) {
  QS_NEEDS_SHARED("scenes/plush.spz");
  Pair& renderers = Pair::of("scenes/plush.spz");
  const Camera camera = cameras_of("plush").at(16);
  RenderSettings settings = settings_of_pipeline();
  settings.mode = kReferenceMode;
  const Image reference = renderers.cpu->render(camera, settings).color;
  settings.mode = default_mode();
  const Image first = renderers.gpu->render(camera, settings).color;
  EXPECT_GE(psnr_8bit(first, reference), 80.0);
  EXPECT_EQ(renderers.gpu->render(camera, settings).color.values, first.values) << "second run";
}

}  // namespace
}  // namespace qs
