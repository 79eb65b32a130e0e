// SPDX-License-Identifier: MIT
// Compiled alone: it has macros of its own.
//
// bench --plugin: this project's renderer as a plugin, the installed example, and plugins with one
// defect each, every plugin in a separate process.
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/plugin/plugin_renderer.h"
#include "app/report/bench_report.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "raster/scene/image_metrics.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::ProgramRun;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// The offsets that the header documents.
static_assert(sizeof(QsScene) == 80 && offsetof(QsScene, positions) == 24 &&
              offsetof(QsScene, sh) == 56 && offsetof(QsScene, opacities) == 72);
static_assert(sizeof(QsView) == 176 && offsetof(QsView, focal_px) == 96 &&
              offsetof(QsView, near_depth) == 128 && offsetof(QsView, background) == 144 &&
              offsetof(QsView, width) == 160 && offsetof(QsView, antialiased) == 172);
static_assert(sizeof(QsFrame) == 64 && offsetof(QsFrame, pairs) == 16 &&
              offsetof(QsFrame, frame_ms) == 24 && offsetof(QsFrame, stage_ms) == 32);
static_assert(sizeof(QsPlugin) == 56 && offsetof(QsPlugin, name) == 16 &&
              offsetof(QsPlugin, open) == 32 && offsetof(QsPlugin, close) == 48);

class Plugins : public testing::Test {
 protected:
  void SetUp() override {
    test::write_scene(cloud_, scene_);
    std::vector<Camera> cameras;
    for (int i = 0; i < 2; ++i) cameras.push_back(test::front_camera(64 + 16 * i, 48));
    test::write_cameras(cameras, folder_ / "cameras.json");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // The plugin with the behaviour of this name (tests/plugin/behaviours.cpp).
  std::string plugin(const std::string& behaviour) const {
    const std::filesystem::path library = folder_ / (behaviour + ".so");
    std::filesystem::copy_file(QS_BEHAVIOURS_PLUGIN, library,
                               std::filesystem::copy_options::skip_existing);
    return library.string();
  }

  std::unique_ptr<PluginRenderer> opened(const std::string& library) const {
    auto renderer = std::make_unique<PluginRenderer>(PluginOptions{library}, test::pool(2));
    renderer->upload(cloud_, {});
    return renderer;
  }

  ProgramRun bench(const std::string& plugins, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"bench",  scene_,      "--frames", "2",         "--warmup",
                                      "1",      "--backend", "cpu",      "--out-dir", path("out"),
                                      "--cull", "quadbox",   "--plugin", plugins};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_quadsplat(words);
  }

  BenchReport report(const std::string& out = "out") const {
    return parse_bench_report(
        parse_own_json(read_text_file(folder_ / out / "bench.json", 1 << 26)));
  }

  // Rows of a mode or plugin.
  static std::vector<BenchRow> rows_of(const BenchReport& report, const std::string& mode) {
    std::vector<BenchRow> rows;
    std::copy_if(report.rows.begin(), report.rows.end(), std::back_inserter(rows),
                 [&](const BenchRow& row) { return row.mode == mode; });
    return rows;
  }

  std::string text_of(const std::string& file) const {
    return read_text_file(folder_ / file, 1 << 26);
  }

  TemporaryFolder folder_;
  GaussianCloud cloud_ = test::random_cloud(300, 2, 11);
  std::string scene_ = path("scene.ply");
};

// Compares the images, pairs and visible Gaussians of a backend with its plugin's.
void expect_as_built_in(Backend backend, PluginRenderer& plugin, const GaussianCloud& cloud,
                        Pipeline pipeline = kDefaultPipeline) {
  const auto own = make_renderer(backend, test::pool(2));
  own->upload(cloud, {});
  RenderSettings plain, every;
  plain.mode = every.mode = find_culler("quadbox");
  plain.pipeline = every.pipeline = pipeline;
  every.background = {0.25f, 0.5f, 0.75f};
  every.splat_scale = 1.5f;
  every.sh_degree = 1;
  every.antialiased = true;
  every.dilation = 0.1;
  Camera camera = test::front_camera(70, 50);
  camera.view_from_world[3].x = 0.125;
  camera.center_px.y += 3.25;
  camera.near_depth = 0.5;
  for (const RenderSettings& settings : {plain, every}) {
    for (const Camera& view : {camera, test::front_camera(33, 20)}) {
      const Frame& frame = static_cast<Renderer&>(plugin).render(view, settings);
      const Frame& expected = own->render(view, settings);
      EXPECT_EQ(frame.color.values, expected.color.values);
      EXPECT_EQ(frame.stats.tile_pairs, expected.stats.tile_pairs);
      EXPECT_EQ(frame.stats.visible, expected.stats.visible);
      EXPECT_GT(frame.stats.frame_ms, 0);
    }
  }
}

TEST_F(Plugins, the_own_renderer_draws_the_same_bits_and_lists_the_same_pairs_as_built_in) {
  const auto plugin = opened(QS_OWN_CPU_PLUGIN);
  EXPECT_EQ(plugin->name(), "own-cpu");
  expect_as_built_in(Backend::cpu, *plugin, cloud_);
  EXPECT_GE(plugin->call_factor(), 1 / 1.02);
  RenderSettings points;
  points.style = DrawStyle::points;
  const auto draw = [&] {
    static_cast<Renderer&>(*plugin).render(test::front_camera(8, 8), points);
  };
  EXPECT_EQ(test::error_of(draw), "plugin own-cpu: plugins draw splats only");
  plugin->close();
}

#ifdef QS_OWN_CUDA_PLUGIN
TEST_F(Plugins, the_own_cuda_renderer_draws_the_same_bits_and_lists_the_same_pairs_as_built_in) {
  const std::string problem = gpu_report().problem;
  if (!problem.empty()) GTEST_SKIP() << "no GPU: " << problem;
  const struct {
    const char *library, *name;
    bool on_device;
  } cases[] = {{QS_OWN_CUDA_PLUGIN, "own-cuda", false},
               {QS_OWN_CUDA_DEVICE_PLUGIN, "own-cuda-device", true}};
  for (const auto& each : cases) {
    for (const Pipeline pipeline : pipelines_of(Backend::cuda)) {
      const char* const pipeline_name = kPipelineNames[static_cast<int>(pipeline)];
      SCOPED_TRACE(fmt::format("{}, {}", each.name, pipeline_name));
      setenv("QS_OWN_PIPELINE", pipeline_name, 1);  // for the process of the plugin
      const auto plugin = opened(each.library);
      EXPECT_EQ(plugin->name(), each.name);
      EXPECT_EQ(plugin->on_device(), each.on_device);
      expect_as_built_in(Backend::cuda, *plugin, cloud_, pipeline);
      EXPECT_TRUE(plugin->measures_itself());
      plugin->close();
    }
  }
  unsetenv("QS_OWN_PIPELINE");
}
#endif

#if defined(QS_OWN_CUDA_DEVICE_PLUGIN) && !defined(QS_OWN_CUDA_PLUGIN)
TEST_F(Plugins, the_own_renderer_on_an_emulated_device_agrees_with_the_cpu) {
  const auto own = make_renderer(Backend::cpu, test::pool(2));
  own->upload(cloud_, {});
  RenderSettings settings;
  settings.background = {0.25f, 0.5f, 0.75f};
  const Camera camera = test::front_camera(70, 50);
  const Frame& expected = own->render(camera, settings);
  setenv("LD_LIBRARY_PATH", QS_FAKE_CUDA_FOLDER, 1);  // for the processes of the plugin
  for (const char* pipeline : kPipelineNames) {
    SCOPED_TRACE(pipeline);
    setenv("QS_OWN_PIPELINE", pipeline, 1);
    const auto plugin = opened(QS_OWN_CUDA_DEVICE_PLUGIN);
    EXPECT_TRUE(plugin->on_device());
    const Frame& frame = static_cast<Renderer&>(*plugin).render(camera, settings);
    EXPECT_GT(psnr(frame.color, expected.color, test::pool(2)), 100);
    EXPECT_EQ(frame.stats.tile_pairs, expected.stats.tile_pairs);
    EXPECT_EQ(frame.stats.visible, expected.stats.visible);
    plugin->close();
  }
  unsetenv("QS_OWN_PIPELINE");
  unsetenv("LD_LIBRARY_PATH");
}
#endif

TEST_F(Plugins, the_arrays_and_the_image_keep_their_order_in_every_layout_and_memory) {
  setenv("LD_LIBRARY_PATH", QS_FAKE_CUDA_FOLDER, 1);  // for the processes of the plugins
  for (const char* behaviour : {"draws", "draws_planes", "draws_on_device"}) {
    const auto renderer = opened(plugin(behaviour));
    for (const int width : {40, 24}) {
      Renderer& drawing = *renderer;
      const Image image = drawing.render(test::front_camera(width, 30)).color;
      EXPECT_EQ(image.at(7, 11, 0), 7.0f / 256) << behaviour;
      EXPECT_EQ(image.at(7, 11, 1), 11.0f / 256) << behaviour;
      EXPECT_FLOAT_EQ(image.at(7, 11, 2), 1 / (1 + std::exp(-cloud_.opacity_logits[0])));
    }
    EXPECT_EQ(renderer->on_device(), behaviour == std::string("draws_on_device"));
    EXPECT_FALSE(renderer->measures_itself());
    const Frame& frame = renderer->render(test::front_camera(40, 30), {}, {}, DeviceImage{}, {});
    EXPECT_TRUE(frame.color.values.empty());
    EXPECT_GT(frame.stats.frame_ms, 0);
    renderer->close();
  }
  unsetenv("LD_LIBRARY_PATH");
}

TEST_F(Plugins, bench_measures_a_plugin_in_turns_with_the_modes) {
  const ProgramRun run = bench(QS_OWN_CPU_PLUGIN, {"--rounds", "2", "--baseline", "quadbox"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const BenchReport report = this->report();
  const std::vector<BenchRow> own = rows_of(report, "own-cpu"),
                              built_in = rows_of(report, "quadbox");
  ASSERT_EQ(own.size(), 2u);
  ASSERT_EQ(built_in.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(own[i].backend, "plugin");
    EXPECT_EQ(own[i].pipeline, built_in[i].pipeline);
    EXPECT_EQ(own[i].view, built_in[i].view);
    EXPECT_EQ(own[i].pairs, built_in[i].pairs);
    EXPECT_EQ(own[i].visible, built_in[i].visible);
    EXPECT_EQ(own[i].psnr_vs_reference, built_in[i].psnr_vs_reference);
    EXPECT_EQ(own[i].ssim_vs_reference, built_in[i].ssim_vs_reference);
    EXPECT_EQ(own[i].flip_vs_reference, built_in[i].flip_vs_reference);
    EXPECT_GT(own[i].ssim_vs_reference.value(), 0.999);
    EXPECT_LT(own[i].flip_vs_reference.value(), 0.001);
    EXPECT_EQ(own[i].repeats, true);
    EXPECT_EQ(own[i].round_ms.size(), 2u);
    EXPECT_GT(own[i].ms_median, 0);
    EXPECT_GT(own[i].blend_ms, 0);
  }
  EXPECT_THAT(text_of("out/ratios.csv"), HasSubstr("scene,,own-cpu,cpu,quadbox,"));
  EXPECT_THAT(run.out, AllOf(HasSubstr("| `own-cpu` | 300 | "),
                             HasSubstr("from the camera's arrival to the finished image"),
                             HasSubstr("- `own-cpu`: quadsplat's own renderer as a plugin; "),
                             HasSubstr("its times are measured by the plugin"),
                             Not(HasSubstr("Plugins that failed"))));
  EXPECT_THAT(text_of("out/fps.gp"), HasSubstr("linecolor rgb \"#D92626\" title \"own-cpu\""));
  EXPECT_THAT(text_of("out/bench.csv"), HasSubstr(",own-cpu,cpu,plugin,64,48,300,"));
}

TEST_F(Plugins, every_failure_is_a_sentence_and_the_rest_is_measured) {
  std::ofstream(folder_ / "text.so") << "no library\n";
  const struct {
    std::string library, sentence;
  } cases[] = {
      {path("text.so"), "scene: plugin text.so: cannot be loaded: "},
      {path("missing.so"), "scene: plugin missing.so: cannot be loaded: "},
      {QS_FAKE_CUDA_FOLDER "/libcuda.so.1",
       "scene: plugin libcuda.so.1: is no plugin: it does not export qs_plugin()"},
      {plugin("has_another_version"),
       "scene: plugin has_another_version.so: has version 2 of the interface, but this program has "
       "version 1"},
      {plugin("has_no_name"), "scene: plugin has_no_name.so: has a name that is not"},
      {plugin("crashes_at_open"),
       "scene: plugin crashes_at_open.so: crashed with signal 6 (Aborted) while opening the scene"},
      {plugin("throws_at_open"),
       "scene: plugin throws_at_open.so: crashed with signal 6 (Aborted)"},
      {plugin("refuses_to_open"),
       "scene: plugin refuses_to_open.so: open() returned 7: 300 Gaussians are too many"},
      {plugin("crashes_in_render"),
       "scene, camera 0: plugin crashes_in_render: crashed with signal 6 (Aborted) while "
       "rendering"},
      {plugin("ends_its_process"),
       "scene, camera 1: plugin ends_its_process: ended its process with exit code 3 while "
       "rendering"},
      {plugin("refuses_to_render"),
       "scene, camera 0: plugin refuses_to_render: render() returned -1: there is no such view"},
      {plugin("returns_nan"),
       "scene, camera 0: plugin returns_nan: 1 of 9216 values of its image "
       "are not finite or were not written, first at pixel 5,2"},
      {plugin("writes_nothing"),
       "scene, camera 1: plugin writes_nothing: 11520 of 11520 values of its image"},
      {plugin("returns_nonsense_as_time"),
       "scene, camera 0: plugin returns_nonsense_as_time: returned a frame time of nan ms"},
      {plugin("returns_too_long_a_time"),
       "scene, camera 0: plugin returns_too_long_a_time: returned a frame time of 100000000.000 ms "
       "for a call that took "},
      {plugin("crashes_at_close"),
       "scene: plugin crashes_at_close: crashed with signal 6 (Aborted) while closing the scene"}};
  std::vector<std::string> libraries;
  for (const auto& each : cases) libraries.push_back(each.library);
  libraries.emplace_back(QS_OWN_CPU_PLUGIN);
  const ProgramRun run = bench(joined(libraries, ","));
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  for (const auto& each : cases) {
    EXPECT_THAT(run.err, HasSubstr("quadsplat: warning: " + each.sentence));
    EXPECT_THAT(text_of("out/bench.md"), HasSubstr("\n- " + each.sentence));
  }
  const BenchReport report = this->report();
  EXPECT_EQ(rows_of(report, "quadbox").size(), 2u);
  EXPECT_EQ(rows_of(report, "own-cpu").size(), 2u);
  EXPECT_EQ(rows_of(report, "crashes_at_close").size(), 2u);
  EXPECT_EQ(report.rows.size(), 6u) << "a plugin that failed has a row";
  EXPECT_THAT(run.out, Not(HasSubstr("not part of a report")));
}

TEST_F(Plugins, a_plugin_that_does_not_answer_is_ended_after_the_timeout) {
  const ProgramRun run = bench(plugin("never_answers"), {"--plugin-timeout", "5"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const std::string sentence =
      "never_answers: did not answer within 5 s while rendering, so its "
      "process was ended";
  EXPECT_THAT(run.err, HasSubstr(sentence));
  EXPECT_EQ(run.err.find(sentence), run.err.rfind(sentence)) << "it is left out of the other view";
  EXPECT_EQ(report().rows.size(), 2u);
}

TEST_F(Plugins, a_crash_in_one_view_leaves_the_others) {
  const ProgramRun run = bench(plugin("crashes_on_wide_views"), {"--camera-index", "1,0,1,0"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_EQ(rows_of(report(), "crashes_on_wide_views").size(), 2u);
  EXPECT_EQ(rows_of(report(), "quadbox").size(), 4u);
}

TEST_F(Plugins, pictures_that_differ_from_frame_to_frame_are_reported) {
  const ProgramRun run = bench(plugin("draws_another_picture_each_time") + "," + plugin("draws"));
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  for (const BenchRow& row : report().rows)
    EXPECT_EQ(row.repeats, row.mode != "draws_another_picture_each_time") << row.mode;
}

TEST_F(Plugins, two_plugins_of_one_name_are_two_rows) {
  const std::string library = plugin("draws");
  ASSERT_EQ(bench(library + "," + library).exit_code, kExitOk);
  EXPECT_EQ(rows_of(report(), "draws").size(), 2u);
  EXPECT_EQ(rows_of(report(), "draws-2").size(), 2u);
}

TEST_F(Plugins, a_gpu_that_is_missing_is_a_sentence) {
  setenv("LD_LIBRARY_PATH", QS_FAKE_CUDA_FOLDER, 1);  // it has device 0 only
  PluginOptions options{plugin("draws_on_device")};
  options.device = 5;
  PluginRenderer renderer(options, test::pool(2));
  EXPECT_EQ(test::error_of([&] { renderer.upload(cloud_, {}); }, ErrorKind::device),
            "plugin draws_on_device.so: CUDA's driver: cuDeviceGet: error 101");
  unsetenv("LD_LIBRARY_PATH");
}

TEST_F(Plugins, shards_with_plugins_merge_with_their_problems) {
  const std::string plugins = plugin("crashes_on_wide_views");
  const auto shard = [&](const std::string& part, const std::string& out) {
    return bench(plugins, {"--shard", part, "--out-dir", path(out)}).exit_code;
  };
  ASSERT_EQ(shard("1/2", "one"), kExitOk);
  ASSERT_EQ(shard("2/2", "two"), kExitOk);
  const ProgramRun merged =
      test::run_quadsplat({"merge", path("one"), path("two"), "--out-dir", path("both")});
  ASSERT_EQ(merged.exit_code, kExitOk) << merged.err;
  EXPECT_EQ(rows_of(report("both"), "crashes_on_wide_views").size(), 1u);
  EXPECT_THAT(text_of("both/bench.md"),
              AllOf(HasSubstr("\n- scene, camera 1: plugin crashes_on_wide_views: crashed"),
                    HasSubstr("\n- `crashes_on_wide_views`: a test; ")));
}

TEST_F(Plugins, the_installed_example_builds_and_agrees_with_the_reference) {
  const auto run = [](const std::string& command) {
    return std::system(("(" + command + ") > /dev/null 2>&1").c_str());
  };
  const std::string prefix = path("installed"), build = path("build");
  ASSERT_EQ(run(fmt::format("'{}' --install '{}' --component plugin --prefix '{}'", QS_CMAKE,
                            QS_BUILD_FOLDER, prefix)),
            0);
  ASSERT_EQ(run(fmt::format("'{0}' -S '{1}/share/quadsplat/examples/plugin' -B '{2}' "
                            "-DCMAKE_PREFIX_PATH='{1}' && '{0}' --build '{2}'",
                            QS_CMAKE, prefix, build)),
            0);
  const ProgramRun bench = this->bench(build + "/libexample_plugin.so", {"--antialiased", "on"});
  ASSERT_EQ(bench.exit_code, kExitOk) << bench.err;
  const std::vector<BenchRow> rows = rows_of(report(), "example");
  ASSERT_EQ(rows.size(), 2u);
  for (const BenchRow& row : rows) {
    EXPECT_GT(row.psnr_vs_reference.value(), 90);
    EXPECT_EQ(row.repeats, true);
  }
}

}  // namespace
}  // namespace qs
