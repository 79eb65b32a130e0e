// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
//
// Two other implementations of 3DGS make the mistakes, and the judge must name them. The first
// reads the kit's files; the second is the plugin that is installed as an example, called through
// the interface of plugins.
#include <cstdlib>
#include <fstream>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/conformance/judge.h"
#include "app/conformance/kit_scenes.h"
#include "app/plugin/plugin_renderer.h"
#include "app/support/plugin_in_process.h"
#include "app/support/run_program.h"
#include "base/text.h"
#include "io/picture/image_file.h"
#include "support/all_combinations.h"
#include "support/planted_renderer.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

std::vector<std::string> words_of(const MistakeSet& set) {
  std::vector<std::string> names;
  for (const std::size_t mistake : set) names.emplace_back(mistakes()[mistake].name);
  return names;
}

struct Implementation {
  const char* name;
  Image (*draw)(std::size_t scene, const std::vector<std::string>& mistakes);
  std::size_t pair_step;  ///< under sanitizers every n-th pair is tried; QS_ALL_PAIRS: all of them
};

class Planted : public testing::TestWithParam<Implementation> {
 public:
  static Image draw_by_reader(std::size_t scene, const std::vector<std::string>& mistakes) {
    return test::draw_planted(scenes_[scene], {mistakes.begin(), mistakes.end()});
  }
  // QS_MISTAKES names the mistakes.
  static Image draw_by_plugin(std::size_t scene, const std::vector<std::string>&) {
    static const test::PluginInProcess plugin(QS_PLANTED_PLUGIN);
    const KitView& view = views_[scene];
    return plugin.draw(view.cloud, view.camera, view.settings);
  }

 protected:
  static void SetUpTestSuite() {
    TemporaryFolder folder;
    write_kit(folder.path(), test::pool(0));
    const auto kit = nlohmann::json::parse(std::ifstream(folder / "kit.json"));
    for (const auto& entry : kit["scenes"])
      scenes_.push_back(test::read_planted(folder.path(), entry));
    for (const KitScene& scene : kit_scenes()) views_.push_back(scene.make());
    variants_ = std::make_unique<Variants>(2, test::pool(0));
  }
  static void TearDownTestSuite() { variants_.reset(); }

  static Submission draw(const MistakeSet& planted) {
    const std::vector<std::string> names = words_of(planted);
    setenv("QS_MISTAKES", joined(names, ",").c_str(), 1);
    Submission submission;
    submission.problems.resize(scenes_.size());
    submission.pictures.resize(scenes_.size());
    test::pool(0).for_chunks(scenes_.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i)
        submission.pictures[i] = picture8(GetParam().draw(i, names));
    });
    unsetenv("QS_MISTAKES");
    return submission;
  }
  static KitVerdict judged(const Submission& submission) {
    return judge_kit(submission, *variants_, test::pool(0));
  }
  // The mistakes of a pair that can be seen: "a + b" is "a" if the implementation draws all scenes
  // with `a` alone like with both, within the tolerance.
  static MistakeSet visible(const MistakeSet& pair, const Submission& submission) {
    static std::map<std::string, std::vector<Submission>> drawn;
    std::vector<Submission>& singles = drawn[GetParam().name];
    if (singles.empty()) {
      for (const MistakeSet& set : sets_of_mistakes(1)) singles.push_back(draw(set));
    }
    for (const std::size_t mistake : pair) {
      bool same = true;
      for (std::size_t i = 0; i < scenes_.size(); ++i)
        same =
            same && fit_of(submission.pictures[i], singles[mistake].pictures[i], kLargestDifference)
                        .matches();
      if (same) return {mistake};
    }
    return pair;
  }

  static inline std::vector<test::PlantedScene> scenes_;
  static inline std::vector<KitView> views_;
  static inline std::unique_ptr<Variants> variants_;
};

INSTANTIATE_TEST_SUITE_P(Conformance, Planted,
                         testing::Values(Implementation{"reader", Planted::draw_by_reader, 1},
                                         Implementation{"plugin", Planted::draw_by_plugin, 8}),
                         [](const auto& each) { return each.param.name; });

// The failed scenes that no cause draws.
std::string unexplained(const KitVerdict& judgement) {
  std::string names;
  for (std::size_t i = 0; i < kit_scenes().size(); ++i) {
    const SceneVerdict& verdict = judgement.scenes[i];
    if (verdict.result == Result::failed && verdict.causes.empty())
      names += std::string(" ") + kit_scenes()[i].name;
  }
  return names;
}

std::string names_of_all(const std::vector<MistakeSet>& sets) {
  std::string names;
  for (const MistakeSet& set : sets) names += (names.empty() ? "" : " or ") + names_of(set);
  return names;
}

TEST_P(Planted, the_other_implementation_passes_without_mistakes) {
  const KitVerdict judgement = judged(draw({}));
  for (std::size_t i = 0; i < kit_scenes().size(); ++i) {
    EXPECT_EQ(judgement.scenes[i].result, Result::passed)
        << kit_scenes()[i].name << ": " << judgement.scenes[i].fit.psnr << " dB, "
        << judgement.scenes[i].fit.largest;
    EXPECT_LE(judgement.scenes[i].fit.largest, 1) << kit_scenes()[i].name;
  }
  EXPECT_TRUE(judgement.causes.empty());
}

TEST_P(Planted, every_mistake_fails_and_is_named) {
  for (const MistakeSet& planted : sets_of_mistakes(1)) {
    const KitVerdict judgement = judged(draw(planted));
    EXPECT_GE(judgement.count(Result::failed), 1u) << names_of(planted);
    EXPECT_EQ(names_of_all(judgement.causes), names_of(planted));
    EXPECT_EQ(judgement.explained, judgement.count(Result::failed)) << names_of(planted);
    for (std::size_t i = 0; i < kit_scenes().size(); ++i) {
      if (judgement.scenes[i].result != Result::failed) continue;
      EXPECT_EQ(names_of_all(judgement.scenes[i].causes), names_of(planted))
          << kit_scenes()[i].name;
    }
  }
}

TEST_P(Planted, every_pair_of_mistakes_fails_and_is_named) {
  std::size_t pairs = 0, hidden = 0;
  const std::vector<MistakeSet> sets = sets_of_mistakes(2);
  const std::size_t step = std::getenv("QS_ALL_PAIRS") != nullptr ? 1
                           : test::kAllCombinations               ? GetParam().pair_step
                                                                  : 8;
  for (std::size_t set = 0; set < sets.size(); set += step) {
    const MistakeSet& planted = sets[set];
    const Submission submission = draw(planted);
    const MistakeSet expected = visible(planted, submission);
    const KitVerdict judgement = judged(submission);
    EXPECT_EQ(names_of_all(judgement.causes), names_of(expected)) << names_of(planted);
    EXPECT_EQ(judgement.explained, judgement.count(Result::failed))
        << names_of(planted) << unexplained(judgement);
    ++pairs;
    hidden += expected.size() == 1;
  }
  EXPECT_LE(hidden, pairs / 50);  // only where one mistake hides the other
}

TEST_P(Planted, pictures_of_an_unknown_mistake_are_not_explained) {
  Submission submission = draw({});
  for (std::uint8_t& value : submission.pictures[2])
    value = static_cast<std::uint8_t>(value / 2 + 60);
  const KitVerdict judgement = judged(submission);
  EXPECT_EQ(judgement.count(Result::failed), 1u);
  EXPECT_EQ(judgement.scenes[2].result, Result::failed);
  EXPECT_TRUE(judgement.scenes[2].causes.empty());
  EXPECT_TRUE(judgement.causes.empty());
}

TEST_P(Planted, three_mistakes_are_found_one_after_the_other) {
  MistakeSet planted;
  for (std::size_t i = 0; i < mistakes().size(); ++i) {
    const std::string name = mistakes()[i].name;
    if (name == "dilation-missing" || name == "sh-opposite" || name == "bright-clamped")
      planted.push_back(i);
  }
  ASSERT_EQ(planted.size(), 3u);
  const KitVerdict judgement = judged(draw(planted));
  EXPECT_EQ(names_of_all(judgement.causes), names_of(planted));
  EXPECT_EQ(judgement.explained, judgement.count(Result::failed));
}

TEST(PlantedPlugin, the_command_names_what_a_plugin_does_wrong_in_its_process) {
  TemporaryFolder folder;
  setenv("QS_MISTAKES", "dilation-missing,order-reversed", 1);  // for the process of the plugin
  PluginRenderer plugin({QS_PLANTED_PLUGIN}, test::pool(2));
  for (const KitScene& scene : kit_scenes()) {
    const KitView view = scene.make();
    plugin.upload(view.cloud, {});
    EXPECT_EQ(plugin.name(), "example-with-mistakes");
    const Image image = static_cast<Renderer&>(plugin).render(view.camera, view.settings).color;
    write_image(image, folder / (std::string(scene.name) + ".png"));
    plugin.close();
  }
  unsetenv("QS_MISTAKES");
  const test::ProgramRun run =
      test::run_quadsplat({"conformance", "--judge", folder.path().string()});
  EXPECT_EQ(run.exit_code, kExitComparison);
  EXPECT_THAT(run.out, testing::HasSubstr("order-reversed + dilation-missing"));
}

}  // namespace
}  // namespace qs
