// SPDX-License-Identifier: MIT
#include "learn/run/photograph_cache.h"

#include <algorithm>
#include <cmath>
#include <numbers>
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

double sinc(double x) {
  const double angle = std::numbers::pi * x;
  return x == 0 ? 1 : std::sin(angle) / angle;
}

// The weight at a distance in new values.
double weight_at(double t, ReductionFilter filter) {
  t = std::abs(t);
  if (filter == ReductionFilter::triangle) return std::max(0.0, 1 - t);
  return t < 2 ? sinc(t) * sinc(t / 2) : 0;
}

std::vector<Taps> all_taps(int from, int to, ReductionFilter filter) {
  std::vector<Taps> taps;
  for (int i = 0; i < to; ++i) taps.push_back(reduction_taps(from, to, i, filter));
  return taps;
}

struct Size {
  int width = 0, height = 0;
};

// `channels` values per pixel, 8 bits each.
std::vector<std::uint8_t> resized(std::span<const std::uint8_t> pixels, int channels, Size from,
                                  Size to, ReductionFilter filter, ThreadPool& pool) {
  std::vector<std::uint8_t> result(static_cast<std::size_t>(to.width * channels) *
                                   static_cast<std::size_t>(to.height));
  resample(
      pixels, from.width, channels, all_taps(from.width, to.width, filter),
      all_taps(from.height, to.height, filter), pool,
      [](double sum) { return static_cast<std::uint8_t>(std::clamp(std::lround(sum), 0L, 255L)); },
      result.data());
  return result;
}

// The old values that new value i covers, even in part.
struct Covered {
  int begin, end;

  Covered(int from, int to, int i)
      : begin(static_cast<int>(std::int64_t{i} * from / to)),
        end(static_cast<int>((std::int64_t{i + 1} * from + to - 1) / to)) {}
};

// A pixel counts if all old pixels count that it covers. If no pixel counted then, those count that
// cover one.
std::vector<std::uint8_t> resized_mask(std::span<const std::uint8_t> mask, Size from, Size to) {
  std::vector<std::uint8_t> all, any;
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      const Covered rows(from.height, to.height, y), columns(from.width, to.width, x);
      int counted = 0;
      for (int v = rows.begin; v < rows.end; ++v)
        for (int u = columns.begin; u < columns.end; ++u)
          counted += mask[static_cast<std::size_t>(v) * static_cast<std::size_t>(from.width) +
                          static_cast<std::size_t>(u)];
      all.push_back(counted == (rows.end - rows.begin) * (columns.end - columns.begin) ? 1 : 0);
      any.push_back(counted > 0 ? 1 : 0);
    }
  }
  return std::ranges::find(all, std::uint8_t{1}) == all.end() ? any : all;
}

}  // namespace

Taps reduction_taps(int from, int to, int i, ReductionFilter filter) {
  const double step = static_cast<double>(from) / to;
  const double center = (i + 0.5) * step;
  const double reach = (filter == ReductionFilter::triangle ? 1 : 2) * step;
  Taps taps;
  taps.first = std::max(static_cast<int>(center - reach + 0.5), 0);
  const int end = std::min(static_cast<int>(center + reach + 0.5), from);
  double sum = 0;
  for (int j = taps.first; j < end; ++j) {
    taps.weights.push_back(weight_at((j + 0.5 - center) / step, filter));
    sum += taps.weights.back();
  }
  for (double& weight : taps.weights) weight /= sum;
  return taps;
}

PhotographView reduced(const PhotographView& view, int factor, ReductionFilter filter,
                       ThreadPool& pool) {
  const Size from{view.camera.width, view.camera.height};
  const Size to{std::max(1, from.width / factor), std::max(1, from.height / factor)};
  const LensCamera camera = LensCamera{view.camera, view.lens, {}}.scaled(to.width, to.height);
  PhotographView result{camera.camera, camera.lens, view.source, {}, {}, {}};
  result.rgb = resized(view.rgb, 3, from, to, filter, pool);
  if (!view.alpha.empty()) result.alpha = resized(view.alpha, 1, from, to, filter, pool);
  if (!view.mask.empty()) result.mask = resized_mask(view.mask, from, to);
  return result;
}

bool ReducedPhotographs::set_factor(int factor) {
  if (factor == factor_) return false;
  factor_ = factor;
  std::ranges::fill(views_, std::nullopt);
  passing_.reset();
  return true;
}

const PhotographView& ReducedPhotographs::view(std::size_t number, const PhotographView& full,
                                               bool keeps) {
  if (factor_ == 1) return full;
  std::optional<PhotographView>& place = keeps ? views_[number] : passing_;
  if (!keeps || !place) place = reduced(full, factor_, filter_, pool_);
  return *place;
}

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
  for (const PhotographView* view : wanted_)
    if (!held_.contains(view) && !being_read_.contains(view) && !errors_.contains(view))
      return view;
  return nullptr;
}

// Removes views that are not wanted, the least recently used first, until there is room for `view`.
// The view in use and the next view may exceed the limit. Needs the mutex.
bool PhotographCache::make_room(const PhotographView& view) {
  const auto is_wanted = [&](const PhotographView* other) {
    return std::ranges::find(wanted_, other) != wanted_.end();
  };
  while (bytes_ + view.bytes() > limit_) {
    auto oldest = held_.end();
    for (auto entry = held_.begin(); entry != held_.end(); ++entry) {
      if (is_wanted(entry->first)) continue;
      if (oldest == held_.end() || entry->second.last_use < oldest->second.last_use) oldest = entry;
    }
    if (oldest == held_.end())
      return &view == wanted_[0] || (wanted_.size() > 1 && &view == wanted_[1]);
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
