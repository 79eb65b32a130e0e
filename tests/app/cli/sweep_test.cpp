// SPDX-License-Identifier: MIT
//
// Every option of every command, with the samples of the tables of options, on a tiny scene in this
// process. Each run ends with 0 or with one sentence. Under the sanitizers every pair of options
// runs, which finds options that crash only together.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <random>
#include <set>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/cli/command.h"
#include "base/error.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "io/scene/writer.h"
#include "support/all_combinations.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using Words = std::vector<std::string>;

// Sends stdout to /dev/null while it lives.
class SilentStdout {
 public:
  SilentStdout() : kept_(dup(STDOUT_FILENO)) {
    std::fflush(stdout);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    close(nowhere);
  }
  ~SilentStdout() {
    std::fflush(stdout);
    dup2(kept_, STDOUT_FILENO);
    close(kept_);
  }
  SilentStdout(const SilentStdout&) = delete;
  SilentStdout& operator=(const SilentStdout&) = delete;

 private:
  int kept_;
};

// An option with one of its samples.
struct Setting {
  std::size_t option;
  std::string value;
};
using Pair = std::pair<std::size_t, std::size_t>;  // of settings, ascending

class Sweep : public testing::TestWithParam<Command> {
 protected:
  // The files that the tables of options name as samples.
  void SetUp() override {
    before_ = std::filesystem::current_path();
    std::filesystem::current_path(folder_.path());
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    setenv("PATH", "", 1);  // without gnuplot, which takes a second
    GaussianCloud cloud = test::random_cloud(150, 1, 11);
    cloud.positions[0] = {0, 0, 3};  // an opaque Gaussian in the middle of the picture
    cloud.log_scales[0] = glm::vec3(-1);
    cloud.opacity_logits[0] = 8;
    test::write_scene(cloud, "scene.ply");
    std::filesystem::create_directories("model/point_cloud/iteration_1");
    std::filesystem::copy("scene.ply", "model/point_cloud/iteration_1/point_cloud.ply");
    std::filesystem::create_directories("images");
    std::vector<Camera> cameras;
    for (int i = 0; i < 2; ++i) {
      Camera camera = test::front_camera(48, 32);
      camera.view_from_world[3].x = 0.1 * i;
      camera.name = fmt::format("view{}", i);
      cameras.push_back(camera);
      write_image(Image(48, 32, 3), "images/" + camera.name + ".ppm");
    }
    test::write_cameras(cameras, "cameras.json");
    std::filesystem::create_directories("covers");
    Image cover(48, 32, 1);
    cover.values[7] = 1;
    write_image(cover, "covers/view0.png");
    write_image(Image(48, 32, 3), "reference.pfm");
    std::ofstream("scene.measures.json") << R"({"version": 1, "lines": []})";
    const Words frames = {"--frames", "1", "--warmup", "0", "--cull", "quadbox", "--out-dir"};
    for (const char* shard : {"1", "2"}) {
      const std::string out = std::string("shard") + shard;
      Words bench = {"bench", "scene.ply", "--shard", std::string(shard) + "/2"};
      bench.insert(bench.end(), frames.begin(), frames.end());
      bench.push_back(out);
      ASSERT_EQ(run(bench), kExitOk) << sentence_;
    }
    Words zoom = {"zoom", "scene.ply", "--target", "0,0,4", "--steps", "2"};
    zoom.insert(zoom.end(), frames.begin(), frames.end());
    zoom.emplace_back("zoom");
    ASSERT_EQ(run(zoom), kExitOk) << sentence_;
    ASSERT_EQ(run({"conformance", "--out-dir", "kit"}), kExitOk) << sentence_;
  }
  void TearDown() override { std::filesystem::current_path(before_); }

  // The exit code; sentence_ holds the message of an Error. No other exception may leave the
  // program. stderr names the command line, so that its last lines explain a crash.
  int run(const Words& words) {
    fmt::print(stderr, "quadsplat {}\n", joined(words, " "));
    sentence_.clear();
    const SilentStdout silent;
    try {
      return run_program(words);
    } catch (const Error& error) {
      sentence_ = error.what();
      fmt::print(stderr, "  {}\n", sentence_);
      return static_cast<int>(error.kind());
    }
  }

  // Samples of the options as settings; a flag has one, without a value.
  std::vector<Setting> settings_of(const std::vector<Option>& table) const {
    std::vector<Setting> settings;
    for (std::size_t i = 0; i < table.size(); ++i) {
      if (table[i].most == 0) settings.push_back({i, ""});
      for (const std::string& sample : table[i].samples) settings.push_back({i, sample});
    }
    return settings;
  }

  // The command line of some settings: required options that are not set get their first sample.
  Words command_line(const std::vector<Option>& table, const std::vector<Setting>& settings) const {
    Words words = {GetParam().name};
    const auto add = [&](const Option& option, const std::string& value) {
      if (!option.positional()) words.push_back(option.name);
      if (option.most != 0) words.push_back(value);
    };
    std::set<std::string> set;
    for (const Setting& setting : settings) {
      add(table[setting.option], setting.value);
      set.insert(table[setting.option].name);
    }
    for (const Option& option : table) {
      if (set.count(option.name) != 0) continue;
      if (option.required) add(option, option.samples.front());
      // Small values instead of the defaults, which are 1280 x 720 and many frames.
      if (option.name == "--size") words.insert(words.end(), {"--size", "48x32"});
      if (option.name == "--warmup") words.insert(words.end(), {"--warmup", "0", "--frames", "1"});
      if (option.name == "--iterations") words.insert(words.end(), {"--iterations", "2"});
      if (option.name == "--random-points") words.insert(words.end(), {"--random-points", "50"});
      if (option.name == "--seconds" && GetParam().name != std::string("train"))
        words.insert(words.end(), {"--seconds", "0.1"});
      if (option.name == "--overwrite") words.emplace_back("--overwrite");
      if (option.name == "--steps") words.insert(words.end(), {"--steps", "2"});
    }
    if (set.count("--path-steps") > set.count("--camera-path"))
      words.insert(words.end(), {"--camera-path", "cameras.json"});
    // The first sample that a run without any setting can take.
    const std::string name = GetParam().name;
    if (name == "render" && set.count("--output") == 0 && set.count("--stats") == 0)
      words.insert(words.end(), {"--output", "out.ppm"});
    if (name == "conformance" && set.count("--judge") == 0)
      words.insert(words.end(), {"--judge", "kit/truth"});
    // An address of no machine, because a server does not end.
    if (name == "serve" && set.count("--address") == 0)
      words.insert(words.end(), {"--address", "192.0.2.1"});
    const bool encrypts = set.count("--certificate") + set.count("--key") > 0;
    const bool serves =
        encrypts || set.count("--port") + set.count("--address") + set.count("--name") > 0;
    if (name == "train" && serves && set.count("--serve") == 0) words.emplace_back("--serve");
    if ((name == "zoom" || name == "view") && set.count("SCENE") + set.count("--replay") == 0)
      words.emplace_back("scene.ply");
    return words;
  }

  TemporaryFolder folder_;
  std::filesystem::path before_;
  std::string sentence_;
};

TEST_P(Sweep, no_options_crash) {
  constexpr std::size_t kMost = 8;  // settings of a run
  // At best `view` finds no display, `paper` no Python, and `serve` no such address.
  const std::string name = GetParam().name;
  const bool headless = name == "view" || name == "paper" || name == "serve";
  Options options(GetParam().name, GetParam().summary);
  const CommandAction action = GetParam().declare(options);
  const std::vector<Option>& table = options.table();
  const std::vector<Setting> settings = settings_of(table);

  std::set<Pair> left;
  for (std::size_t a = 0; a < settings.size(); ++a) {
    for (std::size_t step = 1; step < settings.size(); ++step) {
      const std::size_t b = (a + step) % settings.size();
      if (settings[a].option == settings[b].option) continue;
      left.emplace(std::min(a, b), std::max(a, b));
      if (!test::kAllCombinations) break;
    }
  }
  std::mt19937 random(1);
  std::vector<std::size_t> order(settings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t pairs = left.size();
  int runs = 0, successes = 0;
  while (!left.empty()) {
    // A pair that was not run yet, and compatible settings of other options.
    std::vector<std::size_t> row = {left.begin()->first, left.begin()->second};
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t candidate : order) {
      if (row.size() == kMost) break;
      const bool fits = std::all_of(row.begin(), row.end(), [&](std::size_t other) {
        return settings[other].option != settings[candidate].option;
      });
      const bool gains = std::any_of(row.begin(), row.end(), [&](std::size_t other) {
        return left.count({std::min(other, candidate), std::max(other, candidate)}) != 0;
      });
      if (fits && gains) row.push_back(candidate);
    }
    // An error hides the effect of the other settings, so it counts only for a run of the pair
    // alone.
    for (;; row.resize(row.size() > 4 ? 4 : 2)) {
      std::vector<Setting> chosen;
      for (const std::size_t setting : row) chosen.push_back(settings[setting]);
      const Words words = command_line(table, chosen);
      const int code = run(words);
      ++runs;
      successes += code == kExitOk ? 1 : 0;
      const std::string line = joined(words, " ") + ": ";
      ASSERT_TRUE(code == kExitOk || code == kExitComparison || !sentence_.empty()) << line;
      ASSERT_TRUE(code >= kExitOk && code <= kExitComparison) << line;
      ASSERT_EQ(sentence_.find('\n'), std::string::npos) << line << sentence_;
      const bool ended = sentence_.empty() || (headless && code == kExitDevice);
      if (ended || row.size() == 2) break;
    }
    for (const std::size_t a : row) {
      for (const std::size_t b : row) left.erase({a, b});
    }
  }
  fmt::print("{}: {} options, {} pairs, {} runs, {} of them succeed\n", GetParam().name,
             table.size(), pairs, runs, successes);
  EXPECT_GT(successes, headless ? -1 : runs / 9) << "errors hide what the options do";
}

TEST_P(Sweep, nonsense_values_end_with_a_sentence_or_are_taken) {
  Options options(GetParam().name, GetParam().summary);
  const CommandAction action = GetParam().declare(options);
  const std::vector<Option>& table = options.table();
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table[i].most == 0) continue;
    for (const char* value :
         {"", "-", "-1", "\xff", "nan", "99999999999999999999", ",", "x", "1/"}) {
      const Words words = command_line(table, {{i, value}});
      const int code = run(words);
      EXPECT_TRUE(code == kExitOk || !sentence_.empty()) << table[i].name << " " << value;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Commands, Sweep, testing::ValuesIn(commands().begin(), commands().end()),
                         [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace qs
