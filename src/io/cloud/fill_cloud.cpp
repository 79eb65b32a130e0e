// SPDX-License-Identifier: MIT
#include "io/cloud/fill_cloud.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <vector>

#include "base/fail.h"
#include "base/list_of.h"
#include "base/seconds.h"
#include "io/cloud/cloud_memory.h"

namespace qs {
namespace {

// Limits beyond which squares overflow a float. Trained scenes stay far inside: log scales in
// -20..0, colours in -5..5.
constexpr float kMaxPosition = 1e19f;
constexpr float kMaxLogScale = 40;
constexpr float kMaxColor = 1e6f;
// Logit of 1/255, below which nothing is drawn.
constexpr float kFaintestLogit = -5.5373f;
// A few Gaussians may look odd by chance, but not as many as this.
constexpr std::size_t kEnoughToJudge = 64;

constexpr std::array<const char*, 5> kFlawNames = {
    "a position that is NaN, infinite or beyond 1e19",
    "a scale that is NaN, infinite or beyond e^40",
    "a rotation that is zero, NaN or infinite",
    "an opacity that is NaN",
    "a colour that is NaN, infinite or beyond 1e6",
};

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// False for NaN. The loop has no early exit, so that it becomes vector code.
constexpr bool kSigned = false, kAbsolute = true;
template <bool kIsAbsolute>
bool all_at_most(const float* values, std::size_t count, float bound) {
  int outside = 0;
  for (std::size_t i = 0; i < count; ++i)
    outside |= !((kIsAbsolute ? std::abs(values[i]) : values[i]) <= bound);
  return outside == 0;
}

class Sieve {
 public:
  explicit Sieve(GaussianCloud& cloud) : cloud_(cloud) {}

  // Checks the Gaussians [begin, end) right after they were filled, while they are in the cache.
  // May be called from several threads for disjoint ranges.
  void inspect(std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    if (count == 0) return;
    const std::size_t coefficients = sh_count(cloud_);
    const float* const scales = &cloud_.log_scales[begin].x;
    const float* const logits = &cloud_.opacity_logits[begin];

    const bool rotations_sound = normalise_rotations(begin, end);
    const bool sound =
        rotations_sound &&
        all_at_most<kAbsolute>(&cloud_.positions[begin].x, 3 * count, kMaxPosition) &&
        all_at_most<kSigned>(scales, 3 * count, kMaxLogScale) &&
        all_at_most<kSigned>(logits, count, kInfinity) &&
        all_at_most<kAbsolute>(&cloud_.sh[begin * coefficients].x, 3 * count * coefficients,
                               kMaxColor);
    std::vector<Dropped> found;
    if (!sound) find_flaws(begin, end, found);

    // In most scenes these loops end at the first element.
    const bool scales_positive =
        std::all_of(scales, scales + 3 * count, [](float value) { return value > 0; });
    const bool transparent =
        std::all_of(logits, logits + count, [](float value) { return value < kFaintestLogit; });

    const std::lock_guard lock(mutex_);
    dropped_.insert(dropped_.end(), found.begin(), found.end());
    all_scales_positive_ = all_scales_positive_ && scales_positive;
    all_transparent_ = all_transparent_ && transparent;
  }

  // Removes the Gaussians that inspect() rejected and adds the warnings to `scene`, which owns the
  // cloud.
  void finish(Scene& scene) {
    const std::size_t count = cloud_.size();
    if (count == 0) fail("{}: holds no Gaussians", scene.path.string());
    std::array<std::size_t, kFlaws> counts{};
    for (const Dropped& dropped : dropped_) ++counts[dropped.flaw];
    for (std::size_t flaw = 0; flaw < kFlaws; ++flaw) {
      if (counts[flaw] == count)
        fail("{}: every one of its {} Gaussians has {}", scene.path.string(), count,
             kFlawNames[flaw]);
      if (counts[flaw] == 0) continue;
      scene.warn("{} of {} Gaussians were dropped for {}.", counts[flaw], count, kFlawNames[flaw]);
    }
    if (dropped_.size() == count)
      fail("{}: none of its {} Gaussians can be drawn: all have NaN, infinite or absurd values",
           scene.path.string(), count);
    if (!dropped_.empty()) remove_dropped();
    if (all_scales_positive_ && count >= kEnoughToJudge)
      scene.warn(
          "The scales look already activated: all logarithms are positive, so that every Gaussian "
          "is larger than one unit; drawing may be slow.");
    if (all_transparent_)
      scene.warn("Nothing will be visible: every Gaussian is fainter than 1/255.");
  }

  // Removes the Gaussians that inspect() rejected and returns their indices, in increasing order.
  std::vector<std::size_t> remove() {
    if (!dropped_.empty()) remove_dropped();
    return list_of<std::size_t>(dropped_, &Dropped::index);
  }

 private:
  static constexpr std::size_t kFlaws = kFlawNames.size();
  struct Dropped {
    std::size_t index, flaw;  // flaw: the first, an index into kFlawNames
  };

  // Computes in double precision, in which the square of 1e-30 does not underflow and the square of
  // 1e30 does not overflow. Quaternions that are unit length up to float rounding are not changed:
  // writing and reading them is exact.
  bool normalise_rotations(std::size_t begin, std::size_t end) {
    bool sound = true;
    for (std::size_t i = begin; i < end; ++i) {
      glm::quat& q = cloud_.rotations[i];
      const double w = q.w, x = q.x, y = q.y, z = q.z;
      const double square = w * w + x * x + y * y + z * z;
      if (std::abs(square - 1) <= 3e-7) continue;
      const double factor = 1 / std::sqrt(square);
      sound = sound && square > 0 && std::isfinite(square);
      q = glm::quat(static_cast<float>(w * factor), static_cast<float>(x * factor),
                    static_cast<float>(y * factor), static_cast<float>(z * factor));
    }
    return sound;
  }

  void find_flaws(std::size_t begin, std::size_t end, std::vector<Dropped>& found) const {
    const std::size_t coefficients = sh_count(cloud_);
    for (std::size_t i = begin; i < end; ++i) {
      const glm::quat& q = cloud_.rotations[i];
      const bool sound[kFlaws] = {
          all_at_most<kAbsolute>(&cloud_.positions[i].x, 3, kMaxPosition),
          all_at_most<kSigned>(&cloud_.log_scales[i].x, 3, kMaxLogScale),
          q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z > 0.5f,  // NaN after 0/0
          !std::isnan(cloud_.opacity_logits[i]),
          all_at_most<kAbsolute>(&cloud_.sh[i * coefficients].x, 3 * coefficients, kMaxColor)};
      const auto* const flaw = std::find(sound, sound + kFlaws, false);
      if (flaw != sound + kFlaws) found.push_back({i, static_cast<std::size_t>(flaw - sound)});
    }
  }

  // Sorts dropped_.
  void remove_dropped() {
    std::ranges::sort(dropped_, {}, &Dropped::index);
    std::size_t kept = 0;
    auto next = dropped_.begin();
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      if (next != dropped_.end() && next->index == i) {
        ++next;
        continue;
      }
      copy_gaussian(cloud_, i, cloud_, kept++);
    }
    cloud_.resize(kept, cloud_.sh_degree);
  }

  GaussianCloud& cloud_;
  std::mutex mutex_;
  std::vector<Dropped> dropped_;  // in any order of chunks
  bool all_scales_positive_ = true;
  bool all_transparent_ = true;
};

// Hands out chunks. Each worker first takes the chunks of its own contiguous stretch, then helps
// with the other stretches: if two threads filled neighbouring chunks, both would clear the same
// new 2 MiB page.
class Stretches {
 public:
  Stretches(std::size_t chunks, std::size_t workers) : stretches_(workers) {
    for (std::size_t i = 0; i < workers; ++i) {
      stretches_[i].next = chunks * i / workers;
      stretches_[i].end = chunks * (i + 1) / workers;
    }
  }

  // Must be called exactly once per chunk, so that a chunk is always left.
  std::size_t take(std::size_t worker) {
    for (;; worker = (worker + 1) % stretches_.size()) {
      const std::size_t chunk = stretches_[worker].next.fetch_add(1);
      if (chunk < stretches_[worker].end) return chunk;
    }
  }

 private:
  struct Stretch {
    std::atomic<std::size_t> next;
    std::size_t end;
  };
  std::vector<Stretch> stretches_;
};

// Fills the cloud and lets `sieve` inspect it.
void fill_and_inspect(const GaussianCloud& cloud, Sieve& sieve, ThreadPool& pool,
                      const Progress& progress, float start, const Fill& fill) {
  constexpr std::size_t kChunk = 1024;  // about 0.5 MB read and written: stays in the cache
  const std::size_t count = cloud.size();
  const std::size_t chunks = count / kChunk + (count % kChunk != 0 ? 1 : 0);
  Stretches stretches(chunks, static_cast<std::size_t>(pool.size()));
  pool.for_chunks(chunks, 1, [&](std::size_t taken, std::size_t, int worker) {
    if (worker == 0) {
      const float done = static_cast<float>(taken) / static_cast<float>(chunks);
      progress.update(start + (1 - start) * done);
    }
    const std::size_t begin = stretches.take(static_cast<std::size_t>(worker)) * kChunk;
    const std::size_t end = std::min(begin + kChunk, count);
    fill(begin, end);
    sieve.inspect(begin, end);
  });
}

}  // namespace

void fill_cloud(Scene& scene, ThreadPool& pool, const Progress& progress, float start,
                const Fill& fill) {
  const auto start_time = std::chrono::steady_clock::now();
  Sieve sieve(scene.cloud);
  fill_and_inspect(scene.cloud, sieve, pool, progress, start, fill);
  sieve.finish(scene);
  scene.fill_ms = milliseconds_since(start_time);
}

std::vector<std::size_t> fill_drawable(GaussianCloud& cloud, ThreadPool& pool,
                                       const Progress& progress, const Fill& fill) {
  Sieve sieve(cloud);
  fill_and_inspect(cloud, sieve, pool, progress, 0, fill);
  return sieve.remove();
}

void warn_of_missing_rotations(Scene& scene, std::size_t count) {
  scene.warn("{} of {} Gaussians have no valid rotation and were left unrotated.", count,
             scene.cloud.size());
}

void warn_of_missing_sh(Scene& scene, std::size_t count) {
  scene.warn(
      "{} Gaussians have only their base colour: their spherical harmonics are not in the palette.",
      count);
}

}  // namespace qs
