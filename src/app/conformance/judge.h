// SPDX-License-Identifier: MIT
//
// Compares the pictures that a renderer drew of the kit's scenes with the truth, and finds the
// mistakes that explain them: with these mistakes the plain renderer draws the same pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/conformance/plain_renderer.h"

namespace qs {

/// A picture passes if no 8-bit value differs by more than kLargestDifference from the truth's and
/// the PSNR is at least kLeastPsnr. Rounding in single precision and truncation to 8 bits pass; so
/// does a renderer that cuts Gaussians at tiles beyond 3 standard deviations, as 3DGS does.
inline constexpr int kLargestDifference = 3;
inline constexpr double kLeastPsnr = 48;  ///< dB; every value differs by 1: 48.1 dB
/// An explanation is clearly better than another if its squared error is smaller by 3 dB.
inline constexpr double kClearlyBetter = 2;

/// The fit of a picture to an expected picture.
struct Fit {
  double squared_error = 0;  ///< sum over the 8-bit values
  int largest = 0;           ///< difference of an 8-bit value
  double psnr = 0;           ///< dB; infinity if equal

  bool matches() const { return largest <= kLargestDifference && psnr >= kLeastPsnr; }
};

/// Both pictures have the same size. Stops at the first value that differs by more than `limit`:
/// then only `largest` is set.
Fit fit_of(const Picture8& picture, const Picture8& expected, int limit = 255);

/// The pictures that sets of mistakes give for every scene of the kit. Equal pictures are stored
/// once.
class Variants {
 public:
  /// All sets of at most `most` mistakes.
  Variants(int most, ThreadPool& pool, const Progress& progress = {});

  const std::vector<MistakeSet>& sets() const { return sets_; }
  /// The index of a set, if it is one of sets().
  std::optional<std::size_t> find(const MistakeSet& set) const;
  const Picture8& picture(std::size_t scene, std::size_t set) const {
    return pictures_[scene][which_[scene][set]];
  }
  /// The fit of every set. If a set does not match, only `largest` is set.
  std::vector<Fit> fits(std::size_t scene, const Picture8& picture) const;

 private:
  std::vector<MistakeSet> sets_;
  std::vector<std::vector<std::uint32_t>> which_;  // scene, set: index of its picture
  std::vector<std::vector<Picture8>> pictures_;    // scene, different pictures
};

/// The pictures of a renderer, one per scene of the kit; empty if the picture is missing.
struct Submission {
  std::vector<Picture8> pictures;
  /// per scene: the reason why its file is not a picture of it; usually ""
  std::vector<std::string> problems;
};

/// Reads NAME.png of every scene. Throws Error(input) if `folder` has none of them.
Submission read_submission(const std::filesystem::path& folder);

enum class Result { passed, failed, missing };
inline constexpr const char* kResultNames[] = {"pass", "fail", "missing"};

struct SceneVerdict {
  Result result = Result::missing;
  std::string problem;  ///< the file's, if it is not a picture of the scene
  Fit fit;              ///< against the truth
  /// The smallest sets of mistakes that give this picture, best first. Several sets: this scene
  /// cannot distinguish them. Empty: no known mistake explains the picture.
  std::vector<MistakeSet> causes;
  double explained_psnr = 0;  ///< dB against the picture of the first cause
  /// Without causes: the set of at most two mistakes whose picture is closest, and its PSNR in dB.
  /// It is a hint and explains nothing.
  MistakeSet closest = {};
  double closest_psnr = 0;
};

struct KitVerdict {
  std::vector<SceneVerdict> scenes;  ///< parallel to kit_scenes()
  /// The smallest sets that explain most scenes, passing scenes included; best first. Several sets:
  /// the kit cannot distinguish them. Empty: all scenes pass, or no set explains more scenes than
  /// the empty set.
  std::vector<MistakeSet> causes;
  std::size_t explained = 0;  ///< failed scenes that the first of `causes` draws

  std::size_t count(Result result) const;
};

/// `variants` has sets of at most two mistakes. If no two mistakes explain all pictures, mistakes
/// are added one by one while each explains more pictures.
KitVerdict judge_kit(const Submission& submission, const Variants& variants, ThreadPool& pool);

// The verdict as text, JSON and a page with pictures.

/// A line per scene, the totals and the cause.
std::string format_verdict(const KitVerdict& judgement);

/// {"scenes": [{name, result, psnr, largest_difference, causes}, ...], "passed": 27, ...}
std::string verdict_json(const KitVerdict& judgement);

/// An HTML page: for every scene the truth, the picture, their difference with a colour bar from 0
/// to 32, and the picture of the mistakes that explain it. `name` is the renderer's name.
std::string verdict_page(const KitVerdict& judgement, const Submission& submission,
                         const std::string& name);

/// Sentences about the causes: names, descriptions, and the number of scenes that they explain.
std::string cause_text(const KitVerdict& judgement);

/// "a + b or c"; without causes "no known mistake explains it; closest: d, 41.20 dB".
std::string causes_text(const SceneVerdict& verdict);

}  // namespace qs
