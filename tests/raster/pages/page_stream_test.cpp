// SPDX-License-Identifier: MIT
//
// Pages that come late, damaged, too many for the memory, or from a file that changed.
#include "raster/pages/page_stream.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <set>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/error_of.h"
#include "support/pool.h"
#include "support/random_tree.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::uint64_t kPlenty = 1'000'000'000;

class Streamed : public testing::Test {
 protected:
  PageStream stream(std::uint64_t most_bytes = kPlenty) {
    LodPages tree = whole_;
    std::fill(tree.pages.begin() + 1, tree.pages.end(), nullptr);
    return PageStream(
        std::move(tree),
        {"city.rad",
         [this](std::size_t page) {
           ++reads_;
           if (before_read_) before_read_(page);
           return whole_.pages[page];
         },
         [this] { return !changed_; }, std::vector<std::uint64_t>(whole_.pages.size(), 1000)},
        most_bytes);
  }

  std::vector<std::uint64_t> await(PageStream& stream, const LodLimit& limit) {
    StreamedCut made = stream.await_cut(gain_of_scale, limit, pool());
    last_ = std::move(made.cut);
    return nodes_of(whole_, last_);
  }

  std::vector<std::uint64_t> expected(const LodLimit& limit) {
    return nodes_of(whole_, cut_of(whole_, gain_of_scale, limit, pool()));
  }

  LodPages whole_ = random_tree(6000, 100, 9);
  std::function<void(std::size_t page)> before_read_;
  std::atomic<bool> changed_ = false;
  std::atomic<int> reads_ = 0;
  LodCut last_;
};

TEST_F(Streamed, edits_are_of_pages_in_memory_and_of_later_ones_and_go_without_a_trace) {
  PageStream stream = this->stream();
  const LodGain gain(gain_of_scale);
  stream.await_cut(gain, {400}, pool());
  const auto pages = [&] { return stream.await_cut(gain, {6000}, pool()).tree.pages; };
  EXPECT_EQ(stream.edition(), 0u);
  for (const float value : {5.0f, 7.0f}) {  // the second edit replaces the first
    stream.edit_pages(
        [value](LodPage& page) {
          page.selected = GaussianSet(page.nodes.size());
          page.nodes[0].opacities += value + page.cloud.positions[0].x;
          page.cloud.opacity_logits[1] += value;
        },
        pool());
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; const auto& page : pages()) {
      EXPECT_EQ(page->nodes[0].opacities, value + static_cast<float>(100 * i++));
      EXPECT_EQ(page->cloud.opacity_logits[1], value);
      EXPECT_EQ(page->selected.size(), page->nodes.size());
      bytes += page->bytes();
    }
    EXPECT_EQ(stream.facts().bytes, bytes);
  }
  EXPECT_EQ(stream.edition(), 2u);
  stream.edit_pages(nullptr, pool());
  for (const auto& page : pages()) {
    EXPECT_EQ(page->nodes[0].opacities, 0);
    EXPECT_EQ(page->cloud.opacity_logits[1], 0);
    EXPECT_EQ(page->selected.size(), 0u);
  }
  EXPECT_EQ(reads_, 59);
}

TEST_F(Streamed, nodes_follow_the_leaves_that_an_edit_removes_on_other_pages) {
  PageStream stream = this->stream();
  const LodGain gain(gain_of_scale);
  // Every leaf below one node, which has some on other pages.
  std::uint64_t top = 1;
  const auto is_below = [&](std::uint64_t node) {
    while (node > top) node = node_of(whole_, node).parent;
    return node == top;
  };
  while (!is_below(5999)) ++top;
  ASSERT_LT(top, 6u);
  const auto edit = [&](LodPage& page) {
    page.follows_leaves = true;
    for (std::size_t row = 0; row < page.nodes.size(); ++row)
      if (page.nodes[row].child_count == 0 &&
          is_below(static_cast<std::uint64_t>(page.cloud.positions[row].x)))
        page.cloud.opacity_logits[row] = -std::numeric_limits<float>::infinity();
  };
  std::set<std::uint64_t> mixed;
  for (std::uint64_t node = top; node > 0;) mixed.insert(node = node_of(whole_, node).parent);
  const auto expect_removed = [&](const LodPages& tree) {
    for (std::uint64_t i = 0; i < tree.count; ++i) {
      const float opacity = tree.pages[i / 100]->cloud.opacity_logits[i % 100];
      ASSERT_EQ(std::isinf(opacity), is_below(i)) << i;
      ASSERT_EQ(node_of(tree, i).child_count, is_below(i) ? 0 : node_of(whole_, i).child_count);
      ASSERT_EQ(node_of(tree, i).child_count > 0 && node_of(tree, i).gains[0] == 255,
                mixed.contains(i));
    }
  };
  stream.edit_pages(edit, pool());
  const std::uint64_t before = stream.edition();
  expect_removed(stream.whole_tree(pool()));  // pages that come after the edit
  EXPECT_GT(stream.edition(), before);
  stream.edit_pages(nullptr, pool());
  EXPECT_EQ(node_of(stream.whole_tree(pool()), top).child_count, node_of(whole_, top).child_count);
  stream.edit_pages(edit, pool());
  expect_removed(stream.whole_tree(pool()));
}

TEST_F(Streamed, a_page_that_is_read_during_an_edit_has_the_edit) {
  PageStream stream = this->stream();
  std::atomic<bool> edits = true;
  before_read_ = [&](std::size_t) {
    if (!edits.exchange(false)) return;
    stream.edit_pages([](LodPage& page) { page.nodes[0].opacities = 3; }, pool());
  };
  for (const auto& page : stream.await_cut(LodGain(gain_of_scale), {6000}, pool()).tree.pages)
    EXPECT_EQ(page->nodes[0].opacities, 3);
}

TEST_F(Streamed, a_cut_waits_for_all_its_pages_and_reads_no_page_twice) {
  PageStream stream = this->stream();
  for (const std::size_t budget : {1, 50, 400, 2000, 6000}) {
    EXPECT_EQ(await(stream, {budget}), expected({budget})) << budget;
    EXPECT_THAT(last_.missing, IsEmpty());
  }
  EXPECT_EQ(reads_, 59);
  const StreamFacts facts = stream.facts();
  EXPECT_EQ(facts.pages, 60u);
  EXPECT_EQ(facts.resident, 60u);
  EXPECT_EQ(facts.read, 59u);
  EXPECT_EQ(facts.read_bytes, 59'000u);
  EXPECT_EQ(facts.nodes, 6000u);
  EXPECT_THAT(stream.take_sentences(), IsEmpty());
}

TEST_F(Streamed, a_slow_disk_leaves_the_coarser_nodes_and_the_picture_gets_finer) {
  before_read_ = [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  PageStream stream = this->stream();
  const StreamedCut first = stream.cut(gain_of_scale, {3000}, pool());
  EXPECT_THAT(first.cut.missing, testing::Not(IsEmpty()));
  EXPECT_GE(first.cut.count, 1u);
  // Nodes that come open in the place of others with less gain, so the count may also fall a little
  // under way.
  for (int i = 0; i < 500; ++i) {
    const StreamedCut later = stream.cut(gain_of_scale, {3000}, pool());
    EXPECT_LE(later.cut.count, 3000u);
    EXPECT_GE(later.cut.count, first.cut.count);
    if (later.cut.missing.empty()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(nodes_of(whole_, stream.cut(gain_of_scale, {3000}, pool()).cut), expected({3000}));
}

TEST_F(Streamed, a_damaged_page_is_tried_twice_and_its_parents_stay) {
  std::atomic<int> tries = 0;
  before_read_ = [&](std::size_t page) {
    if (page == 3 && ++tries > 0) throw std::runtime_error("city.rad: chunk 3: damaged");
  };
  PageStream stream = this->stream();
  await(stream, {6000});
  EXPECT_EQ(tries, 2);
  EXPECT_THAT(stream.take_sentences(),
              ElementsAre("city.rad: chunk 3: damaged; coarser nodes are drawn in its place"));
  EXPECT_THAT(last_.missing, IsEmpty());
  LodPages tree = whole_;
  tree.pages[3] = nullptr;
  tree.dead.resize(tree.pages.size());
  tree.dead[3] = true;
  EXPECT_EQ(nodes_of(tree, last_), nodes_of(tree, cut_of(tree, gain_of_scale, {6000}, pool())));
  await(stream, {6000});
  EXPECT_EQ(tries, 2);
  EXPECT_THAT(stream.take_sentences(), IsEmpty());
}

TEST_F(Streamed, an_error_that_passes_is_not_seen) {
  std::atomic<int> tries = 0;
  before_read_ = [&](std::size_t page) {
    if (page == 3 && ++tries == 1) throw std::runtime_error("a cable");
  };
  PageStream stream = this->stream();
  EXPECT_EQ(await(stream, {6000}), expected({6000}));
  EXPECT_THAT(stream.take_sentences(), IsEmpty());
}

TEST_F(Streamed, a_changed_file_is_not_read_any_more) {
  PageStream stream = this->stream();
  const auto before = await(stream, {500});
  const std::size_t resident = stream.facts().resident;
  changed_ = true;
  await(stream, {6000});
  EXPECT_EQ(stream.facts().resident, resident);
  EXPECT_THAT(last_.missing, testing::Not(IsEmpty()));
  EXPECT_GE(last_.count, before.size());
  EXPECT_THAT(
      stream.take_sentences(),
      ElementsAre(HasSubstr("city.rad: another program changed it: no more of it is read")));
  const int reads = reads_;
  await(stream, {6000});
  EXPECT_EQ(reads_, reads);
  EXPECT_THAT(stream.take_sentences(), IsEmpty());
  EXPECT_EQ(await(stream, {500}), before);
}

TEST_F(Streamed, memory_of_one_page_draws_that_page) {
  PageStream stream = this->stream(whole_.pages[0]->bytes());
  const auto coarse = await(stream, {6000});
  EXPECT_FALSE(coarse.empty());
  EXPECT_LT(coarse.back(), 100u);
  EXPECT_EQ(reads_, 0);
  EXPECT_THAT(stream.take_sentences(), ElementsAre(HasSubstr("needs more than the 0 MB")));
  await(stream, {6000});
  EXPECT_THAT(stream.take_sentences(), IsEmpty());
}

// The gains of views that open the even and the odd half of a tree.
LodGain half(unsigned odd) {
  return [odd](const LodPage& p, std::size_t row) {
    return p.cloud.positions[row].x < 30 || static_cast<unsigned>(p.nodes[row].parent) % 2 == odd
               ? p.nodes[row].radius
               : 1e-4f;
  };
}

TEST_F(Streamed, pages_of_earlier_views_leave_when_memory_is_short) {
  const std::uint64_t page = whole_.pages[0]->bytes();
  PageStream stream = this->stream(20 * page);
  for (int round = 0; round < 6; ++round) {
    const LodGain gain = half(round % 2);
    const LodCut got = stream.await_cut(gain, {150}, pool()).cut;
    EXPECT_THAT(got.missing, IsEmpty());
    EXPECT_EQ(nodes_of(whole_, got), nodes_of(whole_, cut_of(whole_, gain, {150}, pool())));
    EXPECT_LE(stream.facts().bytes, 20 * page);
  }
}

// Two views that make a cut whenever the stream says so, as windows do.
struct TwoViews {
  TwoViews(PageStream& of, std::size_t of_budget) : stream(of), budget(of_budget) {
    for (std::atomic<int>& due : dues) {
      due = 1;
      numbers.push_back(stream.add_view([&due] { ++due; }));
    }
  }
  ~TwoViews() {
    for (const int number : numbers) stream.remove_view(number);
  }
  // Makes the cuts that are due until none is for a while. Returns the number of cuts.
  int settle() {
    int cuts = 0;
    for (int quiet = 0; quiet < 20 && cuts < 1000; ++quiet) {
      for (unsigned i = 0; i < 2; ++i)
        if (dues[i].exchange(0) > 0) {
          made[i] = stream.cut(half(i), {budget}, pool(), 0, numbers[i]).cut;
          ++cuts;
          quiet = 0;
        }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return cuts;
  }

  PageStream& stream;
  std::size_t budget;
  std::atomic<int> dues[2];
  std::vector<int> numbers;
  LodCut made[2];
};

TEST_F(Streamed, views_share_pages_and_each_has_the_cut_of_its_own) {
  PageStream stream = this->stream();
  TwoViews views(stream, 400);
  EXPECT_LT(views.settle(), 1000);
  for (unsigned i = 0; i < 2; ++i) {
    EXPECT_THAT(views.made[i].missing, IsEmpty());
    EXPECT_EQ(nodes_of(whole_, views.made[i]),
              nodes_of(whole_, cut_of(whole_, half(i), {400}, pool())));
    EXPECT_EQ(stream.facts(views.numbers[i]).reading, 0u);
  }
  EXPECT_EQ(static_cast<std::size_t>(reads_), stream.facts().read);  // no page twice
}

TEST_F(Streamed, views_that_need_more_than_the_memory_do_not_fight) {
  const std::uint64_t page = whole_.pages[0]->bytes();
  for (const std::uint64_t pages : {1, 2, 3, 8, 20, 31}) {
    PageStream stream = this->stream(pages * page);
    TwoViews views(stream, 6000);
    EXPECT_LT(views.settle(), 1000) << pages;  // pages are not read in turns for ever
    for (const LodCut& cut : views.made) {
      EXPECT_GT(cut.count, 0u);
      EXPECT_FALSE(cut.missing.empty());
    }
    if (pages >= 8) {  // neither view has nearly all of the memory
      EXPECT_LT(views.made[0].count, 3 * views.made[1].count) << pages;
      EXPECT_LT(views.made[1].count, 3 * views.made[0].count) << pages;
    }
    EXPECT_LE(stream.facts().bytes, pages * page);
    EXPECT_THAT(stream.take_sentences(), ElementsAre(HasSubstr("needs more than")));
  }
}

TEST_F(Streamed, an_awaited_cut_has_all_the_memory_beside_a_view) {
  const std::uint64_t page = whole_.pages[0]->bytes();
  PageStream stream = this->stream(20 * page);
  TwoViews views(stream, 150);
  views.settle();
  for (unsigned i = 0; i < 4; ++i) {
    const LodCut got = stream.await_cut(half(i % 2), {150}, pool()).cut;
    EXPECT_EQ(nodes_of(whole_, got), nodes_of(whole_, cut_of(whole_, half(i % 2), {150}, pool())));
  }
}

TEST_F(Streamed, a_view_that_left_is_not_told_and_gives_its_share_back) {
  const std::uint64_t page = whole_.pages[0]->bytes();
  PageStream stream = this->stream(20 * page);
  { TwoViews(stream, 6000).settle(); }
  std::atomic<int> due = 0;
  const int alone = stream.add_view([&] { ++due; });
  LodCut cut;
  do {
    cut = stream.cut(half(0), {150}, pool(), 0, alone).cut;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  } while (due.exchange(0) > 0);
  EXPECT_THAT(cut.missing, IsEmpty());
  stream.remove_view(alone);
}

TEST_F(Streamed, pages_that_come_during_a_cut_make_another_due) {
  PageStream stream = this->stream();
  std::atomic<int> due = 0;
  const int view = stream.add_view([&] { ++due; });
  EXPECT_THAT(stream.cut(LodGain(gain_of_scale), {1}, pool(), 0, view).cut.missing, IsEmpty());
  due = 0;
  std::atomic<bool> came = false;
  const LodGain slow([&](const LodPage& page, std::size_t row) {
    ThreadPool alone(1);
    if (!came.exchange(true)) stream.await_cut(LodGain(gain_of_scale), {6000}, alone);
    return gain_of_scale(page, row);
  });
  EXPECT_FALSE(stream.cut(slow, {6000}, pool(), 0, view).cut.missing.empty());
  EXPECT_EQ(due, 1);
  EXPECT_THAT(stream.cut(slow, {6000}, pool(), 0, view).cut.missing, IsEmpty());
  EXPECT_EQ(due, 1);
  stream.remove_view(view);
}

TEST_F(Streamed, short_memory_halves_the_pages_and_goes_on) {
  PageStream stream = this->stream();
  await(stream, {2000});
  const StreamFacts before = stream.facts();
  before_read_ = [](std::size_t) { throw std::bad_alloc(); };
  await(stream, {6000});
  const StreamFacts after = stream.facts();
  EXPECT_LE(after.most_bytes, before.bytes / 2);
  EXPECT_THAT(stream.take_sentences(), testing::Contains(HasSubstr("memory is short")));
  before_read_ = {};
  EXPECT_EQ(await(stream, {30}), expected({30}));
  EXPECT_GE(await(stream, {6000}).size(), 1u);
}

TEST_F(Streamed, ends_while_pages_are_being_read) {
  before_read_ = [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(30)); };
  PageStream stream = this->stream();
  stream.cut(gain_of_scale, {6000}, pool());
}

// Four instances of a tree whose root has 5 leaves.
TEST(StreamedInstances, share_one_page_in_memory) {
  const auto page_of = [](std::size_t nodes) {
    auto page = std::make_shared<LodPage>(*random_tree(nodes, nodes, 1).pages[0]);
    std::ranges::fill(page->nodes, LodFacts{});
    return page;
  };
  const auto top = page_of(5);
  const std::shared_ptr<const LodPage> shared = page_of(6);
  LodPages tree{25, 100, 0, {top, nullptr, nullptr, nullptr, nullptr}};
  LodInstances instances{1, 1, {}};
  top->nodes[0] = {0, 1, 4};
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t base = 100 * (1 + i);
    top->nodes[1 + i] = {0, base + 1, 5};
    instances.placements.push_back({{Transform(glm::dmat4(1))}, glm::mat4x3(1), 1, base});
  }
  tree.instances = std::make_shared<const LodInstances>(instances);
  const std::uint64_t bytes = top->bytes() + shared->bytes();
  PageStream stream(std::move(tree), {"city.json", [&](std::size_t) { return shared; }}, bytes);
  const StreamedCut made =
      stream.await_cut(LodGain([](const LodPage&, std::size_t) { return 1.0f; }), {}, pool());
  EXPECT_EQ(made.cut.count, 20u);
  EXPECT_THAT(made.cut.missing, IsEmpty());
  EXPECT_EQ(stream.facts().bytes, bytes);
  EXPECT_EQ(stream.facts().read, 1u);
  EXPECT_THAT(stream.take_sentences(), IsEmpty());
  EXPECT_EQ(error_of([&] { stream.edit_pages([](LodPage&) {}, pool()); }),
            "city.json: instances share their pages, so they cannot be edited alone");
}

}  // namespace
}  // namespace qs::test
