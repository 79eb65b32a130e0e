// SPDX-License-Identifier: MIT
#include "raster/pages/page_stream.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <new>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "base/fail.h"

namespace qs {
namespace {

// Unpacking a page takes longer than reading it, but a disk may be slow too.
std::size_t reader_count() {
  return std::clamp<std::size_t>(std::thread::hardware_concurrency(), 4, 32);
}

// A page as it was read, with an edit.
std::shared_ptr<const LodPage> edited(const LodPage& page, const PageEdit& edit) {
  auto own = std::make_shared<LodPage>(page);
  if (page.as_read) {
    own->nodes = page.as_read->nodes;
    own->cloud.opacity_logits = page.as_read->cloud.opacity_logits;
    own->selected = GaussianSet();
    own->follows_leaves = false;
    own->as_read = nullptr;
  }
  if (!edit) return own;
  const auto as_read = std::make_shared<LodPage>();
  as_read->nodes = own->nodes;
  as_read->cloud.opacity_logits = own->cloud.opacity_logits;
  own->as_read = as_read;
  edit(*own);
  return own;
}

}  // namespace

PageStream::PageStream(LodPages tree, PageSource source, std::uint64_t most_bytes)
    : source_(std::move(source)),
      tree_(std::move(tree)),
      uses_(tree_.pages.size()),
      owners_(tree_.pages.size()) {
  tree_.dead.resize(tree_.pages.size());
  facts_ = {tree_.count, tree_.pages.size(), 1, 0, 0, 0, tree_.pages[0]->bytes(), most_bytes};
  for (std::size_t i = 0; i < reader_count(); ++i)
    threads_.emplace_back([this](const std::stop_token& stop) { read_pages(stop); });
}

void PageStream::edit_pages(const PageEdit& edit, ThreadPool& pool) {
  const std::lock_guard lock(mutex_);
  if (tree_.instances)
    fail(ErrorKind::usage, "{}: instances share their pages, so they cannot be edited alone",
         source_.name);
  edit_ = edit;
  ++edition_;
  ++events_;
  pool.for_each(tree_.pages.size(), 1, [&](std::size_t i) {
    if (tree_.pages[i]) tree_.pages[i] = edited(*tree_.pages[i], edit);
  });
  std::vector<std::size_t> pages;
  facts_.bytes = 0;
  for (std::size_t i = 0; i < tree_.pages.size(); ++i) {
    if (!tree_.pages[i]) continue;
    pages.push_back(i);
    facts_.bytes += tree_.pages[i]->bytes();
  }
  follow_leaves(pages);
}

// Looks at the nodes of these pages, and then at the parents of nodes that changed.
void PageStream::follow_leaves(const std::vector<std::size_t>& pages) {
  if (!edit_) return;
  constexpr float kGone = -std::numeric_limits<float>::infinity();
  const std::uint64_t size = tree_.page_nodes;
  const auto facts_of = [&](std::uint64_t node) -> const LodFacts& {
    return tree_.pages[node / size]->nodes[node % size];
  };
  const auto is_gone = [&](std::uint64_t node) {
    return facts_of(node).child_count == 0 &&
           tree_.pages[node / size]->cloud.opacity_logits[node % size] == kGone;
  };
  const auto is_mixed = [](const LodFacts& facts) {
    return facts.child_count > 0 && facts.gains[0] == kLodMostSteps;
  };
  std::vector<std::uint64_t> nodes;
  for (const std::size_t page : pages)
    for (std::uint64_t node = page * size; node < page * size + tree_.pages[page]->nodes.size();
         ++node) {
      const LodFacts& facts = facts_of(node);
      if (facts.child_count > 0) nodes.push_back(node);
      if (facts.parent < page * size && (is_gone(node) || is_mixed(facts)))
        nodes.push_back(facts.parent);
    }
  std::map<std::size_t, std::shared_ptr<LodPage>> changed;
  while (!nodes.empty()) {
    const std::uint64_t node = nodes.back();
    nodes.pop_back();
    std::shared_ptr<const LodPage>& page = tree_.pages[node / size];
    if (!page || facts_of(node).child_count == 0) continue;
    const LodFacts& facts = facts_of(node);
    std::uint64_t gone = 0;
    bool mixed = false;
    for (std::uint64_t k = 0; k < facts.child_count; ++k) {
      const std::uint64_t child = facts.first_child + k;
      if (!tree_.pages[child / size]) continue;
      gone += is_gone(child) ? 1 : 0;
      mixed = mixed || is_mixed(facts_of(child));
    }
    const bool is_empty = gone == facts.child_count;
    if (!is_empty && (!page->follows_leaves || !(mixed || gone > 0) || is_mixed(facts))) continue;
    if (facts.parent < node) nodes.push_back(facts.parent);
    std::shared_ptr<LodPage>& own = changed[node / size];
    if (!own) page = own = std::make_shared<LodPage>(*page);
    LodFacts& open = own->nodes[node % size];
    if (!is_empty) {
      open_first(open, tree_.footprint);
      continue;
    }
    open.child_count = 0;
    open.layers = open.opacities = 0;
    own->cloud.opacity_logits[node % size] = kGone;
  }
  if (!changed.empty()) ++edition_;
}

std::uint64_t PageStream::edition() const {
  const std::lock_guard lock(mutex_);
  return edition_;
}

int PageStream::add_view(std::function<void()> report) {
  const std::lock_guard lock(mutex_);
  for (const auto& [number, view] : views_)
    if (view.report) view.report();  // its share of the memory is less now
  views_[++last_view_].report = std::move(report);
  return last_view_;
}

void PageStream::remove_view(int view) {
  const std::lock_guard lock(mutex_);
  views_.erase(view);
}

StreamedCut PageStream::cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
                            float guess, int view) {
  std::unique_lock lock(mutex_);
  StreamedCut result{tree_, {}};
  const std::uint64_t events = events_;
  Array<LodVisit> kept = std::exchange(kept_, {});
  lock.unlock();
  try {
    result.cut = cut_of(result.tree, gain, limit, pool, guess, &kept);
  } catch (const Error& error) {
    fail("{}: {}", source_.name, error.what());
  }
  lock.lock();
  kept_ = std::move(kept);
  ++cuts_;
  View& own = views_[view];
  const std::size_t others = views_.size() - views_.count(0);
  const std::uint64_t share = view == 0 ? facts_.most_bytes : facts_.most_bytes / others;
  const std::uint64_t page_bytes = tree_.pages[0]->bytes();
  std::uint64_t needed = page_bytes;  // of memory
  std::vector<bool> is_counted(owners_.size());
  const auto counts = [&](std::uint32_t page) {  // pages of one content need it once
    const std::size_t content = tree_.content(page);
    const bool is_new = page != 0 && !is_counted[content];
    is_counted[content] = true;
    return is_new;
  };
  own.lacks_pages = !result.cut.missing.empty();
  own.kept.assign(tree_.pages.size(), false);
  std::vector<const LodPart*> parts;  // the largest gain first
  for (const LodPart& part : result.cut.parts) parts.push_back(&part);
  std::ranges::stable_sort(parts, std::ranges::greater(), &LodPart::gain);
  for (const LodPart* const part : parts) {
    uses_[part->page] = {cuts_, part->gain};
    if (counts(part->page)) needed += result.tree.pages[part->page]->bytes();
    own.kept[part->page] = views_.size() == 1 || needed <= share;
  }
  own.wanted.clear();
  for (const LodPart& part : result.cut.missing) {
    if (stopped_) break;
    if (tree_.pages[part.page] || tree_.dead[part.page] || in_flight_.contains(part.page)) continue;
    if (counts(part.page)) needed += page_bytes;
    if (needed > share) {
      // Pages that come may show that fewer are needed.
      if (own.wanted.empty() && !std::exchange(was_full_, true))
        sentences_.push_back(fmt::format(
            "{}: a view needs more than the {} MB of memory for its pages, so it is coarser",
            source_.name, share / 1'000'000));
      break;
    }
    uses_[part.page].gain = part.gain;
    own.wanted.push_back(part.page);
  }
  std::ranges::reverse(own.wanted);
  wanted_changed_.notify_all();
  if (own.lacks_pages && own.report && events_ != events) own.report();  // pages came meanwhile
  return result;
}

StreamedCut PageStream::await_cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
                                  float guess) {
  for (;;) {
    std::unique_lock lock(mutex_);
    const std::uint64_t events = events_;
    lock.unlock();
    StreamedCut result = cut(gain, limit, pool, guess);
    guess = result.cut.limit;
    lock.lock();
    arrived_.wait(lock, [&] {
      return views_[0].wanted.empty() &&
             std::ranges::none_of(result.cut.missing, [&](const LodPart& part) {
               return in_flight_.contains(part.page);
             });
    });
    if (!result.cut.missing.empty() && events_ != events) continue;
    views_.erase(0);
    return result;  // no more pages can come
  }
}

LodPages PageStream::whole_tree(ThreadPool& pool) {
  const LodGain open([](const LodPage&, std::size_t) { return 1.0f; });
  StreamedCut whole = await_cut(open, {}, pool);
  if (was_full_)
    fail(ErrorKind::device, "{}: its {} nodes need more than the {} MB of memory for its pages",
         source_.name, tree_.count, facts_.most_bytes / 1'000'000);
  const std::vector<std::string> sentences = take_sentences();
  if (!sentences.empty()) fail("{}", sentences[0]);
  return std::move(whole.tree);
}

StreamFacts PageStream::facts(int view) const {
  const std::lock_guard lock(mutex_);
  StreamFacts facts = facts_;
  const auto found = views_.find(view);
  if (found != views_.end()) facts.reading = found->second.wanted.size();
  for (const auto& [page, reader] : in_flight_) facts.reading += reader == view ? 1 : 0;
  return facts;
}

std::vector<std::string> PageStream::take_sentences() {
  const std::lock_guard lock(mutex_);
  return std::exchange(sentences_, {});
}

// The view whose page is read next: views take turns.
PageStream::View* PageStream::next_reader() {
  const auto wants = [](const auto& entry) { return !entry.second.wanted.empty(); };
  auto next = std::find_if(views_.upper_bound(last_served_), views_.end(), wants);
  if (next == views_.end()) next = std::ranges::find_if(views_, wants);
  if (next == views_.end()) return nullptr;
  last_served_ = next->first;
  return &next->second;
}

void PageStream::stop_reading() {
  for (auto& [number, view] : views_) view.wanted.clear();
}

void PageStream::read_pages(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  View* reader = nullptr;
  while (wanted_changed_.wait(lock, stop, [&] { return (reader = next_reader()) != nullptr; })) {
    const std::uint32_t page = reader->wanted.back();
    reader->wanted.pop_back();
    if (tree_.pages[page] || !in_flight_.emplace(page, last_served_).second) {
      arrived_.notify_all();
      continue;
    }
    const PageEdit edit = edit_;
    const std::uint64_t edition = edition_;
    lock.unlock();
    std::shared_ptr<const LodPage> got;
    std::string problem;
    bool is_short = false;
    for (int attempt = 0; attempt < 2 && !got && !is_short; ++attempt) try {
        got = source_.read(page);
        if (edit) got = edited(*got, edit);
      } catch (const std::bad_alloc&) {
        is_short = true;
      } catch (const std::exception& error) {
        problem = error.what();
      }
    const bool is_unchanged = source_.is_unchanged();
    lock.lock();
    in_flight_.erase(page);
    if (got && edition != edition_) got = edited(*got, edit_);
    if (!is_unchanged) {
      if (!std::exchange(stopped_, true))
        sentences_.push_back(fmt::format(
            "{}: another program changed it: no more of it is read, so pictures stay coarse",
            source_.name));
      stop_reading();
    } else if (is_short) {
      halve();
    } else {
      store(page, std::move(got), problem);
    }
    arrived_.notify_all();
    for (const auto& [number, view] : views_)
      if (view.lacks_pages && view.report) view.report();
  }
}

void PageStream::store(std::uint32_t page, std::shared_ptr<const LodPage> got,
                       const std::string& problem) {
  if (!got) {
    tree_.dead[page] = true;
    ++events_;
    sentences_.push_back(problem + "; coarser nodes are drawn in its place");
    return;
  }
  std::size_t& owners = owners_[tree_.content(page)];
  if (owners == 0) {
    ++facts_.read;
    if (!source_.stored_bytes.empty()) facts_.read_bytes += source_.stored_bytes[page];
    if (!make_room(got->bytes())) return;
    facts_.bytes += got->bytes();
  }
  ++owners;
  ++facts_.resident;
  ++events_;
  uses_[page].cut = cuts_;
  for (auto& [number, view] : views_)
    if (view.lacks_pages) view.kept[page] = true;  // until its next cut
  tree_.pages[page] = std::move(got);
  follow_leaves({page});
}

void PageStream::halve() {
  facts_.most_bytes = std::min(facts_.most_bytes, facts_.bytes) / 2;
  sentences_.push_back(fmt::format("{}: memory is short: its pages have {} MB now", source_.name,
                                   facts_.most_bytes / 1'000'000));
  make_room(0);
  stop_reading();
}

bool PageStream::make_room(std::uint64_t bytes) {
  const bool awaits = views_.contains(0);
  while (facts_.bytes + bytes > facts_.most_bytes) {
    std::size_t victim = 0;
    const auto order = [&](std::size_t page) {
      return std::tuple(uses_[page].gain, uses_[page].cut);
    };
    const auto is_kept = [&](std::size_t page) {
      return std::ranges::any_of(views_, [&](const auto& entry) {
        const auto& [number, view] = entry;
        return (number == 0 || !awaits) && !view.kept.empty() && view.kept[page];
      });
    };
    for (std::size_t page = 1; page < uses_.size(); ++page)
      if (tree_.pages[page] && !is_kept(page) && (victim == 0 || order(page) < order(victim)))
        victim = page;
    if (victim == 0) return false;
    if (--owners_[tree_.content(victim)] == 0) facts_.bytes -= tree_.pages[victim]->bytes();
    --facts_.resident;
    tree_.pages[victim].reset();
  }
  return true;
}

}  // namespace qs
