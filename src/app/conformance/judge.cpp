// SPDX-License-Identifier: MIT
#include "app/conformance/judge.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>

#include "base/fail.h"
#include "base/list_of.h"
#include "io/picture/image_file.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

constexpr std::size_t kMostMistakes = 6;  // a cause has no more mistakes
constexpr std::size_t kMostCauses = 3;    // a larger number of equal fits explains nothing

// The fit of a set of mistakes to all pictures.
struct Score {
  MistakeSet set;
  std::size_t matched = 0;
  double squared_error = 0;  // sum over the matched pictures
};

// More matches are better, then fewer mistakes, then a smaller error.
bool better(const Score& a, const Score& b) {
  return std::tuple(b.matched, a.set.size(), a.squared_error) <
         std::tuple(a.matched, b.set.size(), b.squared_error);
}

// The best set and all sets that are not clearly worse, best first.
std::vector<MistakeSet> best_sets(std::vector<Score> scores) {
  std::ranges::stable_sort(scores, better);
  std::vector<MistakeSet> sets;
  const Score& best = scores.front();
  for (const Score& score : scores)
    if (score.matched == best.matched && score.set.size() == best.set.size() &&
        score.squared_error <= kClearlyBetter * best.squared_error)
      sets.push_back(score.set);
  return sets;
}

MistakeSet with(MistakeSet set, std::size_t mistake) {
  set.insert(std::ranges::upper_bound(set, mistake), mistake);
  return set;
}

bool excluded(const MistakeSet& set, std::size_t mistake) {
  return std::ranges::any_of(
      set, [&](std::size_t other) { return mistakes()[other].part == mistakes()[mistake].part; });
}

class KitJudge {
 public:
  KitJudge(const Submission& submission, const Variants& variants, ThreadPool& pool)
      : submission_(submission), variants_(variants), pool_(pool) {
    views_.reserve(kit_scenes().size());
    for (const KitScene& scene : kit_scenes()) views_.push_back(scene.make());
  }

  KitVerdict run() {
    measure();
    if (judgement_.count(Result::failed) == 0) return judgement_;
    find_causes();
    for (std::size_t scene = 0; scene < views_.size(); ++scene)
      if (judgement_.scenes[scene].result == Result::failed && fits_.count(scene) != 0)
        explain(scene);
    return judgement_;
  }

 private:
  // The fit of every picture to the pictures of all sets. The first set has no mistakes.
  void measure() {
    std::vector<std::vector<Fit>> fits(views_.size());
    pool_.for_each(views_.size(), 1, [&](std::size_t scene) {
      const Picture8& picture = submission_.pictures[scene];
      if (!picture.empty()) fits[scene] = variants_.fits(scene, picture);
    });
    for (std::size_t scene = 0; scene < views_.size(); ++scene) {
      SceneVerdict& verdict = judgement_.scenes.emplace_back();
      verdict.problem = submission_.problems[scene];
      if (!verdict.problem.empty()) verdict.result = Result::failed;
      if (fits[scene].empty()) continue;
      verdict.fit = fit_of(submission_.pictures[scene], variants_.picture(scene, 0));
      verdict.result = verdict.fit.matches() ? Result::passed : Result::failed;
      fits_.emplace(scene, std::move(fits[scene]));
    }
  }

  static void add(const Fit& fit, Score& score) {
    if (!fit.matches()) return;
    ++score.matched;
    score.squared_error += fit.squared_error;
  }

  void find_causes() {
    std::vector<Score> scores = scores_of_variants();
    for (std::size_t set = 0; set < scores.size(); ++set)
      for (const auto& [scene, fits] : fits_) add(fits[set], scores[set]);
    const std::size_t without = scores.front().matched;
    while (true) {
      const std::vector<MistakeSet> best = best_sets(scores);
      const Score& top = *std::ranges::min_element(scores, better);
      if (top.matched <= std::max(matched_, without)) break;
      matched_ = top.matched;
      judgement_.causes = best;
      if (matched_ == fits_.size() || top.set.size() >= kMostMistakes) break;
      scores = scores_of_larger(top.set);
      if (scores.empty()) break;
    }
    if (!judgement_.causes.empty()) judgement_.explained = explained_by(judgement_.causes.front());
  }

  // A score of 0 for each set of the variants.
  std::vector<Score> scores_of_variants() const {
    return list_of<Score>(variants_.sets(), [](const MistakeSet& set) { return Score{set}; });
  }

  // The scores of the sets that add one mistake to `set`.
  std::vector<Score> scores_of_larger(const MistakeSet& set) {
    std::vector<Score> scores;
    for (std::size_t mistake = 0; mistake < mistakes().size(); ++mistake)
      if (!excluded(set, mistake)) scores.push_back({with(set, mistake)});
    pool_.for_each(scores.size(), 1, [&](std::size_t i) {
      for (const auto& [scene, fits] : fits_) add(fit(scene, scores[i].set), scores[i]);
    });
    return scores;
  }

  // The picture of the scene with these mistakes.
  Picture8 picture_with(std::size_t scene, const MistakeSet& set) const {
    const std::optional<std::size_t> drawn = variants_.find(set);
    return drawn ? variants_.picture(scene, *drawn) : picture8(draw_with(views_[scene], set));
  }

  Fit fit(std::size_t scene, const MistakeSet& set) const {
    return fit_of(submission_.pictures[scene], picture_with(scene, set));
  }

  std::size_t explained_by(const MistakeSet& set) const {
    std::size_t count = 0;
    for (const auto& [scene, fits] : fits_)
      count += judgement_.scenes[scene].result == Result::failed && fit(scene, set).matches();
    return count;
  }

  // The mistakes of the set that change this scene: without them its picture is different.
  MistakeSet visible_part(std::size_t scene, MistakeSet set) const {
    const Picture8 picture = picture_with(scene, set);
    for (std::size_t i = set.size(); i-- > 0;) {
      MistakeSet rest = set;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
      if (picture_with(scene, rest) == picture) set = rest;
    }
    return set;
  }

  void explain(std::size_t scene) {
    SceneVerdict& verdict = judgement_.scenes[scene];
    if (!judgement_.causes.empty()) {
      const Fit common = fit(scene, judgement_.causes.front());
      if (common.matches()) {
        verdict.causes = {visible_part(scene, judgement_.causes.front())};
        verdict.explained_psnr = common.psnr;
        return;
      }
    }
    std::vector<Score> scores = scores_of_variants();
    for (std::size_t set = 0; set < scores.size(); ++set) add(fits_.at(scene)[set], scores[set]);
    const std::vector<MistakeSet> best = best_sets(scores);
    const Fit fitted = fit(scene, best.front());
    if (!fitted.matches() || best.size() > kMostCauses) return find_closest(scene);
    verdict.causes = best;
    verdict.explained_psnr = fitted.psnr;
  }

  void find_closest(std::size_t scene) {
    SceneVerdict& verdict = judgement_.scenes[scene];
    for (std::size_t set = 0; set < variants_.sets().size(); ++set) {
      const double psnr = fit_of(submission_.pictures[scene], variants_.picture(scene, set)).psnr;
      if (psnr <= verdict.closest_psnr) continue;
      verdict.closest_psnr = psnr;
      verdict.closest = variants_.sets()[set];
    }
  }

  const Submission& submission_;
  const Variants& variants_;
  ThreadPool& pool_;
  std::vector<KitView> views_;
  std::map<std::size_t, std::vector<Fit>> fits_;  // fits of the scenes that have a picture
  KitVerdict judgement_;
  std::size_t matched_ = 0;  // scenes that judgement_.causes draw, passing scenes included
};

}  // namespace

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
  for (int count = 0; count <= most; ++count)
    for (MistakeSet& set : sets_of_mistakes(count)) sets_.push_back(std::move(set));
  const std::size_t scenes = kit_scenes().size();
  which_.resize(scenes);
  pictures_.resize(scenes);
  std::mutex mutex;
  std::size_t done = 0;
  pool.for_each(scenes, 1, [&](std::size_t scene) {
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
  });
}

std::optional<std::size_t> Variants::find(const MistakeSet& set) const {
  const auto found = std::ranges::find(sets_, set);
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

Submission read_submission(const std::filesystem::path& folder) {
  Submission submission;
  bool any = false;
  for (const KitScene& scene : kit_scenes()) {
    Picture8& picture = submission.pictures.emplace_back();
    std::string& problem = submission.problems.emplace_back();
    const std::filesystem::path file = folder / (std::string(scene.name) + ".png");
    if (!std::filesystem::exists(file)) continue;
    any = true;
    const Camera camera = scene.make().camera;
    try {
      const Image image = read_image(file);
      if (image.width == camera.width && image.height == camera.height)
        picture = picture8(image);
      else
        problem = fmt::format("it has {} x {} pixels instead of {} x {}", image.width, image.height,
                              camera.width, camera.height);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input) throw;
      problem = error.what();
    }
  }
  if (!any)
    fail("{}: it has no picture of the kit, such as {}.png", folder.string(),
         kit_scenes().front().name);
  return submission;
}

std::size_t KitVerdict::count(Result result) const {
  return static_cast<std::size_t>(std::ranges::count(scenes, result, &SceneVerdict::result));
}

KitVerdict judge_kit(const Submission& submission, const Variants& variants, ThreadPool& pool) {
  return KitJudge(submission, variants, pool).run();
}

}  // namespace qs
