// SPDX-License-Identifier: MIT
#include "learn/run/photograph_cache.h"

#include <algorithm>
#include <utility>

#include "base/fail.h"

namespace qs::train {
namespace {

PhotographView read_again(const PhotographView& view, ThreadPool& pool) {
  PhotographView read = read_view(view.source, pool);
  if (read.content_hash() != view.content_hash())
    fail("{}: was changed while it was trained from", view.source.file.string());
  return read;
}

}  // namespace

PhotographCache::PhotographCache(const DataSet& data) : limit_(data.photo_memory) {
  if (!data.on_disk()) return;
  constexpr unsigned kLeastThreads = 2;
  const unsigned threads =
      std::clamp(std::thread::hardware_concurrency() / 2, kLeastThreads, kMostThreads);
  for (unsigned i = 0; i < threads; ++i)
    threads_.emplace_back([this](const std::stop_token& stop) { read_ahead(stop); });
}

PhotographCache::~PhotographCache() {
  for (std::jthread& thread : threads_) thread.request_stop();  // all, before one is awaited
}

const PhotographView& PhotographCache::view(const PhotographView& wanted,
                                            std::span<const PhotographView* const> next) {
  if (wanted.has_pixels()) return wanted;
  std::unique_lock lock(mutex_);
  wanted_.assign(1, &wanted);
  wanted_.insert(wanted_.end(), next.begin(), next.end());
  errors_.clear();
  changed_.notify_all();
  changed_.wait(lock, [&] { return held_.contains(&wanted) || errors_.contains(&wanted); });
  if (const auto error = errors_.find(&wanted); error != errors_.end())
    std::rethrow_exception(error->second);
  Entry& entry = held_.at(&wanted);
  entry.last_use = ++uses_;
  return entry.view;
}

std::size_t PhotographCache::reads() const {
  const std::lock_guard lock(mutex_);
  return reads_;
}

// The first wanted view that is not in memory, not being read and not unreadable. Needs the mutex.
const PhotographView* PhotographCache::next_to_read() const {
  for (const PhotographView* view : wanted_) {
    if (!held_.contains(view) && !being_read_.contains(view) && !errors_.contains(view))
      return view;
  }
  return nullptr;
}

// Removes views that are not wanted, the least recently used first, until there is room for `view`.
// The view in use and the next view may exceed the limit. Needs the mutex.
bool PhotographCache::make_room(const PhotographView& view) {
  const auto is_wanted = [&](const PhotographView* other) {
    return std::find(wanted_.begin(), wanted_.end(), other) != wanted_.end();
  };
  while (bytes_ + view.bytes() > limit_) {
    auto oldest = held_.end();
    for (auto entry = held_.begin(); entry != held_.end(); ++entry) {
      if (is_wanted(entry->first)) continue;
      if (oldest == held_.end() || entry->second.last_use < oldest->second.last_use) oldest = entry;
    }
    if (oldest == held_.end()) {
      return &view == wanted_[0] || (wanted_.size() > 1 && &view == wanted_[1]);
    }
    bytes_ -= oldest->second.view.bytes();
    held_.erase(oldest);
  }
  return true;
}

void PhotographCache::read_ahead(const std::stop_token& stop) {
  ThreadPool pool(1);
  std::unique_lock lock(mutex_);
  while (true) {
    const PhotographView* view = nullptr;
    changed_.wait(lock, stop, [&] {
      view = next_to_read();
      return view != nullptr && make_room(*view);
    });
    if (stop.stop_requested()) return;
    being_read_.insert(view);
    bytes_ += view->bytes();
    lock.unlock();
    std::optional<PhotographView> read;
    std::exception_ptr error;
    try {
      read = read_again(*view, pool);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    being_read_.erase(view);
    if (read) {
      held_.emplace(view, Entry{std::move(*read), uses_});
      ++reads_;
    } else {
      bytes_ -= view->bytes();
      errors_.emplace(view, error);
    }
    changed_.notify_all();
  }
}

}  // namespace qs::train
