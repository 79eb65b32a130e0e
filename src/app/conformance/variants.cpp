// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>
#include <utility>

#include "app/conformance/judge.h"
#include "raster/scene/image_metrics.h"

namespace qs {

Fit fit_of(const Picture8& picture, const Picture8& expected, int limit) {
  Fit fit;
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const int difference = std::abs(int{picture[i]} - int{expected[i]});
    fit.largest = std::max(fit.largest, difference);
    if (difference > limit) return fit;
    sum += static_cast<std::uint64_t>(difference * difference);
  }
  fit.squared_error = static_cast<double>(sum);
  fit.psnr = psnr_of(fit.squared_error / static_cast<double>(picture.size()), 255);
  return fit;
}

Variants::Variants(int most, ThreadPool& pool, const Progress& progress) {
  for (int count = 0; count <= most; ++count) {
    for (MistakeSet& set : sets_of_mistakes(count)) sets_.push_back(std::move(set));
  }
  const std::size_t scenes = kit_scenes().size();
  which_.resize(scenes);
  pictures_.resize(scenes);
  std::mutex mutex;
  std::size_t done = 0;
  pool.for_chunks(scenes, 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t scene = begin; scene < end; ++scene) {
      const KitView view = kit_scenes()[scene].make();
      std::map<Picture8, std::uint32_t> known;
      for (const MistakeSet& set : sets_) {
        const auto [entry, added] = known.try_emplace(picture8(draw_with(view, set)),
                                                      static_cast<std::uint32_t>(known.size()));
        if (added) pictures_[scene].push_back(entry->first);
        which_[scene].push_back(entry->second);
      }
      const std::lock_guard lock(mutex);
      progress.update(static_cast<float>(++done) / static_cast<float>(scenes));
    }
  });
}

std::optional<std::size_t> Variants::find(const MistakeSet& set) const {
  const auto found = std::find(sets_.begin(), sets_.end(), set);
  if (found == sets_.end()) return {};
  return static_cast<std::size_t>(found - sets_.begin());
}

std::vector<Fit> Variants::fits(std::size_t scene, const Picture8& picture) const {
  std::vector<Fit> different, all;
  for (const Picture8& expected : pictures_[scene])
    different.push_back(fit_of(picture, expected, kLargestDifference));
  for (const std::uint32_t which : which_[scene]) all.push_back(different[which]);
  return all;
}

}  // namespace qs
