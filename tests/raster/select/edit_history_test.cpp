// SPDX-License-Identifier: MIT
//
// The history of editing against a plain model that keeps every state.
#include "raster/select/edit_history.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

using testing::SizeIs;

std::string no_hash(const GaussianSet&) { return {}; }

// A random step; most select.
EditStep random_step(std::mt19937& random, std::size_t gaussians) {
  const auto below = [&](int most) {
    return static_cast<int>(random() % static_cast<unsigned long>(most));
  };
  constexpr EditKind kOthers[] = {EditKind::hide, EditKind::show, EditKind::remove};
  if (below(3) == 0) return {.kind = kOthers[below(3)]};
  SelectStep select;
  select.how = static_cast<SelectHow>(below(4));
  switch (below(5)) {
    case 0:
      select.tool = SelectTool::all;
      break;
    case 1:
      select.tool = SelectTool::invert;
      break;
    case 2:
      select.tool = SelectTool::opacity;
      select.range = {0.01 * below(100), 1};
      break;
    case 3: {  // one run
      const auto first = static_cast<std::uint64_t>(below(static_cast<int>(gaussians)));
      select.tool = SelectTool::list;
      const auto most = static_cast<int>(gaussians - first);
      select.members =
          std::vector<GaussianRun>{{first, 1 + static_cast<std::uint64_t>(below(most))}};
      break;
    }
    default:  // many runs
      select.tool = SelectTool::list;
      select.members.emplace();
      for (std::uint64_t i = static_cast<std::uint64_t>(below(9)); i < gaussians;
           i += 2 + static_cast<std::uint64_t>(below(5)))
        select.members->push_back({i, 1});
  }
  return {.select = select};
}

// 1,000 random steps, undos and redos. `most_bytes`: of the history.
void expect_like_the_model(std::size_t gaussians, std::size_t most_bytes, unsigned seed) {
  std::mt19937 random(seed);
  const GaussianCloud cloud = test::random_cloud(static_cast<int>(gaussians), 0, seed);
  const EditTools tools{cloud, test::pool(), {}, no_hash};
  EditHistory history(gaussians, most_bytes);
  std::vector<EditState> model = {EditState(gaussians)};  // after each step
  std::vector<EditStep> steps;
  std::size_t at = 0, undone = 0, redone = 0;
  for (int turn = 0; turn < 1000; ++turn) {
    const auto dice = random() % 10;
    if (dice < 3) {
      const bool can = history.can_undo();
      history.undo();
      if (can) --at, ++undone;
    } else if (dice < 5) {
      ASSERT_EQ(history.can_redo(), at + 1 < model.size());
      const bool can = history.can_redo();
      history.redo();
      if (can) ++at, ++redone;
    } else {
      const EditStep step = random_step(random, gaussians);
      EditState after = history.state();
      carry_out(step, tools, "test", after);
      model.resize(at + 1, EditState(gaussians));
      steps.resize(at);
      model.push_back(after);
      steps.push_back(step);
      ++at;
      history.take(step, after);
    }
    ASSERT_EQ(history.state(), model[at]) << turn;
    ASSERT_LE(history.memory(), most_bytes);
    ASSERT_THAT(history.steps(), SizeIs(at));
    if (at > 0) {
      ASSERT_EQ(history.steps().back().kind, steps[at - 1].kind);
    }
    // Hidden and removed Gaussians are never selected.
    GaussianSet wrong = history.state().rest().complement();
    ASSERT_TRUE((wrong &= history.state().selected).empty());
  }
  EXPECT_GT(undone, 50u);
  EXPECT_GT(redone, 20u);
  // A replay of the steps leads to the same state.
  EditState replayed(gaussians);
  for (const EditStep& step : history.steps()) carry_out(step, tools, "test", replayed);
  EXPECT_EQ(replayed, history.state());
}

TEST(EditHistory, is_like_a_plain_model_in_1000_random_steps) {
  for (const std::size_t gaussians : {1, 64, 300, 1003})
    expect_like_the_model(gaussians, EditHistory::kMostBytes, static_cast<unsigned>(gaussians));
}

TEST(EditHistory, within_little_memory_only_the_last_steps_have_a_way_back) {
  for (const std::size_t bytes : {100u, 1000u, 10000u}) expect_like_the_model(3000, bytes, 5);
  EditHistory history(64000, 20000);
  GaussianSet half(64000);
  for (std::size_t i = 0; i < half.size(); i += 2) half.add(i);
  for (int step = 0; step < 5; ++step) {
    EditState after = history.state();
    after.selected = step % 2 == 0 ? half : GaussianSet(64000);
    history.take({}, after);
  }
  EXPECT_GT(history.memory(), 8000u);
  int back = 0;
  for (; history.can_undo(); ++back) history.undo();
  EXPECT_EQ(back, 2);
  EXPECT_THAT(history.steps(), SizeIs(3)) << "the steps stay";
  for (; history.can_redo(); --back) history.redo();
  EXPECT_EQ(back, 0);
  EXPECT_EQ(history.state().selected, half);
}

TEST(EditHistory, counts_lists_of_results_and_forgets_them_with_the_way_back) {
  EditHistory history(1000, 3000);
  SelectStep seen;
  seen.members.emplace();
  for (std::uint64_t i = 0; i < 100; ++i) seen.members->push_back({2 * i, 1});
  seen.count = 100;
  for (int step = 0; step < 3; ++step) {
    EditState after = history.state();
    after.selected.toggle(static_cast<std::size_t>(step));
    history.take({.select = seen}, after);
    EXPECT_LE(history.memory(), 3000u);
  }
  const std::vector<EditStep> steps = history.steps();
  EXPECT_FALSE(steps[0].select.members);
  EXPECT_FALSE(steps[0].select.count);
  EXPECT_TRUE(steps[2].select.members);
  EXPECT_EQ(steps[2].select.count, 100u);
}

TEST(EditHistory, copies_are_independent_and_another_size_begins_anew) {
  EditHistory history(100);
  EditState one(100);
  one.removed.add(7);
  history.take({.kind = EditKind::remove}, one);
  const EditHistory copy = history;
  history.undo();
  EXPECT_TRUE(history.state().removed.empty());
  EXPECT_EQ(copy.state().removed.count(), 1u);
  history.take({}, EditState(20));
  EXPECT_THAT(history.steps(), SizeIs(1));
  EXPECT_EQ(history.state().removed.size(), 20u);
  EXPECT_THAT(copy.steps(), SizeIs(1));
}

TEST(SetChange, of_long_runs_takes_little_memory) {
  constexpr std::size_t kSize = 10'000'000;
  GaussianSet half(kSize), scattered(kSize);
  for (std::size_t i = 0; i < kSize / 2; ++i) half.add(i);
  for (std::size_t i = 0; i < kSize; i += 3) scattered.add(i);
  EXPECT_LE(SetChange(GaussianSet(kSize), half).memory(), 16u);
  EXPECT_LE(SetChange(GaussianSet(kSize), scattered).memory(), kSize / 8 + 8);
  GaussianSet there = half;
  const SetChange change(half, scattered);
  change.apply(there);
  EXPECT_EQ(there, scattered);
  change.apply(there);
  EXPECT_EQ(there, half);
  EXPECT_EQ(SetChange(half, half).memory(), 0u);
}

}  // namespace
}  // namespace qs
