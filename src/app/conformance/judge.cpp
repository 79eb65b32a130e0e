// SPDX-License-Identifier: MIT
#include "app/conformance/judge.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

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

bool better(const Score& a, const Score& b) {
  if (a.matched != b.matched) return a.matched > b.matched;
  if (a.set.size() != b.set.size()) return a.set.size() < b.set.size();
  return a.squared_error < b.squared_error;
}

// The best set and all sets that are not clearly worse, best first.
std::vector<MistakeSet> best_sets(std::vector<Score> scores) {
  std::stable_sort(scores.begin(), scores.end(), better);
  std::vector<MistakeSet> sets;
  const Score& best = scores.front();
  for (const Score& score : scores) {
    if (score.matched == best.matched && score.set.size() == best.set.size() &&
        score.squared_error <= kClearlyBetter * best.squared_error)
      sets.push_back(score.set);
  }
  return sets;
}

MistakeSet with(MistakeSet set, std::size_t mistake) {
  set.insert(std::upper_bound(set.begin(), set.end(), mistake), mistake);
  return set;
}

bool excluded(const MistakeSet& set, std::size_t mistake) {
  return std::any_of(set.begin(), set.end(), [&](std::size_t other) {
    return mistakes()[other].part == mistakes()[mistake].part;
  });
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
    for (std::size_t scene = 0; scene < views_.size(); ++scene) {
      if (judgement_.scenes[scene].result == Result::failed && fits_.count(scene) != 0)
        explain(scene);
    }
    return judgement_;
  }

 private:
  // The fit of every picture to the pictures of all sets. The first set has no mistakes.
  void measure() {
    std::vector<std::vector<Fit>> fits(views_.size());
    pool_.for_chunks(views_.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t scene = begin; scene < end; ++scene) {
        const Picture8& picture = submission_.pictures[scene];
        if (!picture.empty()) fits[scene] = variants_.fits(scene, picture);
      }
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
    for (std::size_t set = 0; set < scores.size(); ++set) {
      for (const auto& [scene, fits] : fits_) add(fits[set], scores[set]);
    }
    const std::size_t without = scores.front().matched;
    while (true) {
      const std::vector<MistakeSet> best = best_sets(scores);
      const Score& top = *std::min_element(scores.begin(), scores.end(), better);
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
    std::vector<Score> scores;
    for (const MistakeSet& set : variants_.sets()) scores.push_back({set});
    return scores;
  }

  // The scores of the sets that add one mistake to `set`.
  std::vector<Score> scores_of_larger(const MistakeSet& set) {
    std::vector<Score> scores;
    for (std::size_t mistake = 0; mistake < mistakes().size(); ++mistake) {
      if (!excluded(set, mistake)) scores.push_back({with(set, mistake)});
    }
    pool_.for_chunks(scores.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        for (const auto& [scene, fits] : fits_) add(fit(scene, scores[i].set), scores[i]);
      }
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

std::size_t KitVerdict::count(Result result) const {
  return static_cast<std::size_t>(
      std::count_if(scenes.begin(), scenes.end(),
                    [&](const SceneVerdict& verdict) { return verdict.result == result; }));
}

KitVerdict judge_kit(const Submission& submission, const Variants& variants, ThreadPool& pool) {
  return KitJudge(submission, variants, pool).run();
}

}  // namespace qs
