// SPDX-License-Identifier: MIT
#include "raster/pages/page_stream.h"

#include <algorithm>
#include <exception>
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

}  // namespace

PageStream::PageStream(LodPages tree, PageSource source, std::uint64_t most_bytes)
    : source_(std::move(source)), tree_(std::move(tree)), uses_(tree_.pages.size()) {
  tree_.dead.resize(tree_.pages.size());
  facts_ = {tree_.count, tree_.pages.size(), 1, 0, 0, 0, tree_.pages[0]->bytes(), most_bytes};
  for (std::size_t i = 0; i < reader_count(); ++i)
    threads_.emplace_back([this](const std::stop_token& stop) { read_pages(stop); });
}

StreamedCut PageStream::cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
                            float guess) {
  std::unique_lock lock(mutex_);
  StreamedCut result{tree_, {}};
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
  const std::uint64_t page_bytes = tree_.pages[0]->bytes();
  std::uint64_t needed = page_bytes;  // of memory
  for (const LodPart& part : result.cut.parts) {
    uses_[part.page] = {cuts_, part.gain};
    if (part.page != 0) needed += result.tree.pages[part.page]->bytes();
  }
  wanted_.clear();
  for (const LodPart& part : result.cut.missing) {
    if (stopped_ || wanted_.size() == 4 * threads_.size()) break;
    if (tree_.pages[part.page] || tree_.dead[part.page] || in_flight_.contains(part.page)) continue;
    needed += page_bytes;
    if (needed > facts_.most_bytes) {
      if (!std::exchange(was_full_, true))
        sentences_.push_back(fmt::format(
            "{}: a view needs more than the {} MB of memory for its pages, so it is coarser",
            source_.name, facts_.most_bytes / 1'000'000));
      break;
    }
    uses_[part.page].gain = part.gain;
    wanted_.push_back(part.page);
  }
  std::ranges::reverse(wanted_);
  wanted_changed_.notify_all();
  return result;
}

StreamedCut PageStream::await_cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
                                  float guess) {
  for (;;) {
    std::unique_lock lock(mutex_);
    const std::uint64_t events = events_;
    lock.unlock();
    StreamedCut result = cut(gain, limit, pool, guess);
    if (result.cut.missing.empty()) return result;
    guess = result.cut.limit;
    lock.lock();
    arrived_.wait(lock, [&] { return wanted_.empty() && in_flight_.empty(); });
    if (events_ == events) return result;  // no more pages can come
  }
}

StreamFacts PageStream::facts() const {
  const std::lock_guard lock(mutex_);
  StreamFacts facts = facts_;
  facts.reading = wanted_.size() + in_flight_.size();
  return facts;
}

std::vector<std::string> PageStream::take_sentences() {
  const std::lock_guard lock(mutex_);
  return std::exchange(sentences_, {});
}

void PageStream::read_pages(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (wanted_changed_.wait(lock, stop, [&] { return !wanted_.empty(); })) {
    const std::uint32_t page = wanted_.back();
    wanted_.pop_back();
    in_flight_.insert(page);
    lock.unlock();
    std::shared_ptr<const LodPage> got;
    std::string problem;
    bool is_short = false;
    for (int attempt = 0; attempt < 2 && !got && !is_short; ++attempt) try {
        got = std::make_shared<const LodPage>(source_.read(page));
      } catch (const std::bad_alloc&) {
        is_short = true;
      } catch (const std::exception& error) {
        problem = error.what();
      }
    const bool is_unchanged = source_.is_unchanged();
    lock.lock();
    in_flight_.erase(page);
    if (!is_unchanged) {
      if (!std::exchange(stopped_, true))
        sentences_.push_back(fmt::format(
            "{}: another program changed it: no more of it is read, so pictures stay coarse",
            source_.name));
      wanted_.clear();
    } else if (is_short) {
      halve();
    } else {
      store(page, std::move(got), problem);
    }
    arrived_.notify_all();
    if (report_) report_();
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
  ++facts_.read;
  if (!source_.stored_bytes.empty()) facts_.read_bytes += source_.stored_bytes[page];
  if (!make_room(got->bytes())) return;
  facts_.bytes += got->bytes();
  ++facts_.resident;
  ++events_;
  uses_[page].cut = cuts_;
  tree_.pages[page] = std::move(got);
}

void PageStream::halve() {
  facts_.most_bytes = std::min(facts_.most_bytes, facts_.bytes) / 2;
  sentences_.push_back(fmt::format("{}: memory is short: its pages have {} MB now", source_.name,
                                   facts_.most_bytes / 1'000'000));
  make_room(0);
  wanted_.clear();
}

bool PageStream::make_room(std::uint64_t bytes) {
  while (facts_.bytes + bytes > facts_.most_bytes) {
    std::size_t victim = 0;
    const auto order = [&](std::size_t page) {
      return std::tuple(uses_[page].gain, uses_[page].cut);
    };
    for (std::size_t page = 1; page < uses_.size(); ++page)
      if (tree_.pages[page] && uses_[page].cut != cuts_ &&
          (victim == 0 || order(page) < order(victim)))
        victim = page;
    if (victim == 0) return false;
    facts_.bytes -= tree_.pages[victim]->bytes();
    --facts_.resident;
    tree_.pages[victim].reset();
  }
  return true;
}

}  // namespace qs
