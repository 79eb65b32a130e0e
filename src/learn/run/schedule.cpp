// SPDX-License-Identifier: MIT
#include "learn/run/schedule.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr double kFirstMeanRate = 1.6e-4, kLastMeanRate = 1.6e-6;
constexpr int kMeanRateIterations = 30'000;
constexpr int kShDegreeIterations = 1000;

constexpr double kMostScale = 8, kLeastSpectrum = 0.25;
constexpr int kLevels = 32;  // factors from the first to 1
constexpr int kFirstRenewal = 600, kRenewal = 100;
constexpr double kDetailScale = 2;

// The factor with which the sum within(factor) reaches `wanted`.
double scale_with(double wanted, const std::function<double(double)>& within) {
  double low = 0, high = 1, middle = 1;
  for (int step = 0; step < 64; ++step) {
    middle = (low + high) / 2;
    (within(1 / middle) < wanted ? low : high) = middle;
  }
  return 1 / middle;
}

}  // namespace

Rates rates_at(int iteration, double extent, double opacity_rate, MeanRateStart start) {
  const int falls_for = std::max(1, kMeanRateIterations - start.falls_from);
  const double t =
      std::clamp(static_cast<double>(iteration - start.falls_from) / falls_for, 0.0, 1.0);
  const bool moves = start.moves_before || iteration >= start.falls_from;
  const double mean =
      moves ? std::exp((1 - t) * std::log(kFirstMeanRate) + t * std::log(kLastMeanRate)) : 0;
  return {.mean = mean * extent,
          .log_scale = 5e-3,
          .rotation = 1e-3,
          .opacity = opacity_rate,
          .sh_dc = 2.5e-3,
          .sh_rest = 2.5e-3 / 20};
}

int sh_degree_at(int iteration, int most) {
  return std::min(most, iteration / kShDegreeIterations);
}

std::size_t ViewOrder::at(int iteration) {
  const auto number = static_cast<std::uint64_t>(iteration - 1);
  const std::uint64_t round = number / views_;
  if (round != round_) {
    round_ = round;
    order_.resize(views_);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    const Random random = Random::of(seed_, RandomUse::views, round);
    for (std::size_t left = views_; left > 1; --left)
      std::swap(order_[left - 1], order_[random.bits(left) % left]);
  }
  return order_[number % views_];
}

std::vector<std::size_t> drawn_views(std::size_t views, std::size_t count, std::uint64_t seed,
                                     int iteration) {
  std::vector<std::size_t> order(views);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const Random random =
      Random::of(seed, RandomUse::scored_views, static_cast<std::uint64_t>(iteration));
  count = std::min(count, views);
  for (std::size_t drawn = 0; drawn < count; ++drawn)
    std::swap(order[drawn], order[drawn + random.bits(drawn) % (views - drawn)]);
  order.resize(count);
  return order;
}

void PhotographSpectra::add(const Image& photograph, ThreadPool& pool) {
  const Spectrum spectrum = Spectrum::of(photograph, pool);
  const SpectrumSums sums(spectrum);
  largest_ = std::min(largest_, scale_with(kLeastSpectrum * sums.total(),
                                           [&](double scale) { return sums.within(scale); }));
  ++photographs_;
  for (Spectrum& same : by_size_)
    if (same.width == spectrum.width && same.height == spectrum.height) return same.add(spectrum);
  by_size_.push_back(spectrum);
}

std::vector<SpectrumSums> PhotographSpectra::means() const {
  std::vector<SpectrumSums> means;
  for (Spectrum mean : by_size_) {
    for (double& magnitude : mean.magnitudes) magnitude /= static_cast<double>(photographs_);
    means.emplace_back(mean);
  }
  return means;
}

ResolutionSchedule::ResolutionSchedule(const PhotographSpectra& spectra, int end)
    : scales_{spectra.largest_scale()} {
  const std::vector<SpectrumSums> means = spectra.means();
  const auto within = [&](double scale) {
    double sum = 0;
    for (const SpectrumSums& mean : means) sum += mean.within(scale);
    return sum;
  };
  double total = 0;
  for (const SpectrumSums& mean : means) total += mean.total();
  const double least = within(scales_[0]);
  const double range = std::log(total / least);
  for (int level = 1; level < kLevels - 1 && range > 0; ++level) {
    const double wanted = least + (total - least) * level / (kLevels - 1);
    scales_.push_back(scale_with(wanted, within));
    begins_.push_back(static_cast<int>(end * (std::log(wanted / least) / range)));
  }
  scales_.push_back(1);
  begins_.push_back(end);
}

int ResolutionSchedule::factor_at(int iteration) const {
  const auto next = std::ranges::upper_bound(begins_, iteration);
  if (next == begins_.end()) return 1;
  const auto i = static_cast<std::size_t>(next - begins_.begin());
  const auto detail = [&](std::size_t level) { return 1 / (scales_[level] * scales_[level]); };
  const double t = static_cast<double>(iteration - begins_[i - 1]) / (begins_[i] - begins_[i - 1]);
  const double mixed = detail(i - 1) + t * (detail(i) - detail(i - 1));
  return std::max(1, static_cast<int>(std::sqrt(1 / mixed)));
}

int ResolutionSchedule::factor_in(int iteration) const {
  const int end = begins_.back();
  if (iteration > end) return 1;
  const int last = std::min(iteration - 1, end - 1) / kRenewal * kRenewal;
  return factor_at(last >= kFirstRenewal ? last : 1);
}

int ResolutionSchedule::details_from() const {
  const auto first =
      std::ranges::find_if(scales_, [](double scale) { return scale < kDetailScale; });
  const auto level = static_cast<std::size_t>(first - scales_.begin());
  return begins_[level == 0 ? 0 : level - 1];
}

}  // namespace qs::train
