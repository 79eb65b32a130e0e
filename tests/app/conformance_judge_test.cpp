// SPDX-License-Identifier: MIT
//
// A second implementation of 3DGS makes the mistakes; the judge must name them.
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/conformance/judge.h"
#include "app/conformance/kit_folder.h"
#include "support/planted_renderer.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

class Planted : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    TemporaryFolder folder;
    write_kit(folder.path(), test::pool(0));
    const auto kit = nlohmann::json::parse(std::ifstream(folder / "kit.json"));
    for (const auto& entry : kit["scenes"])
      scenes_.push_back(test::read_planted(folder.path(), entry));
    variants_ = std::make_unique<Variants>(2, test::pool(0));
  }
  static void TearDownTestSuite() { variants_.reset(); }

  static Submission draw(const MistakeSet& planted) {
    std::set<std::string> bugs;
    for (const std::size_t mistake : planted) bugs.insert(mistakes()[mistake].name);
    Submission submission;
    submission.problems.resize(scenes_.size());
    submission.pictures.resize(scenes_.size());
    test::pool(0).for_chunks(scenes_.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i)
        submission.pictures[i] = picture8(test::draw_planted(scenes_[i], bugs));
    });
    return submission;
  }
  static KitVerdict judged(const Submission& submission) {
    return judge_kit(submission, *variants_, test::pool(0));
  }
  // The mistakes of a pair that can be seen: "a + b" is "a" if the second implementation draws
  // all scenes with `a` alone like with both, within the tolerance.
  static MistakeSet visible(const MistakeSet& pair, const Submission& submission) {
    for (const std::size_t mistake : pair) {
      if (singles_.empty()) {
        for (const MistakeSet& set : sets_of_mistakes(1)) singles_.push_back(draw(set));
      }
      bool same = true;
      for (std::size_t i = 0; i < scenes_.size(); ++i)
        same = same && fit_of(submission.pictures[i], singles_[mistake].pictures[i]).matches();
      if (same) return {mistake};
    }
    return pair;
  }

  static inline std::vector<test::PlantedScene> scenes_;
  static inline std::unique_ptr<Variants> variants_;
  static inline std::vector<Submission> singles_;
};

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

TEST_F(Planted, the_second_implementation_passes_without_mistakes) {
  const KitVerdict judgement = judged(draw({}));
  for (std::size_t i = 0; i < kit_scenes().size(); ++i) {
    EXPECT_EQ(judgement.scenes[i].result, Result::passed)
        << kit_scenes()[i].name << ": " << judgement.scenes[i].fit.psnr << " dB, "
        << judgement.scenes[i].fit.largest;
    EXPECT_LE(judgement.scenes[i].fit.largest, 1) << kit_scenes()[i].name;
  }
  EXPECT_TRUE(judgement.causes.empty());
}

TEST_F(Planted, every_mistake_fails_and_is_named) {
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

TEST_F(Planted, every_pair_of_mistakes_fails_and_is_named) {
  std::size_t pairs = 0, hidden = 0;
  for (const MistakeSet& planted : sets_of_mistakes(2)) {
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

TEST_F(Planted, pictures_of_an_unknown_mistake_are_not_explained) {
  Submission submission = draw({});
  for (std::uint8_t& value : submission.pictures[2])
    value = static_cast<std::uint8_t>(value / 2 + 60);
  const KitVerdict judgement = judged(submission);
  EXPECT_EQ(judgement.count(Result::failed), 1u);
  EXPECT_EQ(judgement.scenes[2].result, Result::failed);
  EXPECT_TRUE(judgement.scenes[2].causes.empty());
  EXPECT_TRUE(judgement.causes.empty());
}

TEST_F(Planted, three_mistakes_are_found_one_after_the_other) {
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

}  // namespace
}  // namespace qs
