// SPDX-License-Identifier: MIT
//
// Compares the pictures that a renderer drew of the kit's scenes with the truth, and finds the
// mistakes that explain them: those with which the plain renderer draws the same pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/conformance/mistakes.h"

namespace qs {

/// A picture passes if no 8-bit value differs by more than kLargestDifference from the truth's and
/// the PSNR is at least kLeastPsnr. Rounding in single precision and truncation to 8 bits pass; so
/// does a renderer that cuts Gaussians at tiles beyond 3 standard deviations, as 3DGS does.
inline constexpr int kLargestDifference = 3;
inline constexpr double kLeastPsnr = 48;  ///< dB; every value differs by 1: 48.1 dB
/// An explanation is clearly better than another one if its squared error is smaller by 3 dB.
inline constexpr double kClearlyBetter = 2;

/// How well a picture fits an expected one.
struct Fit {
  double squared_error = 0;  ///< sum over the 8-bit values
  int largest = 0;           ///< difference of an 8-bit value
  double psnr = 0;           ///< dB; infinity if equal

  bool matches() const { return largest <= kLargestDifference && psnr >= kLeastPsnr; }
};

/// Both pictures have the same size. Stops at the first value that differs by more than `limit`:
/// then only `largest` is set.
Fit fit_of(const Picture8& picture, const Picture8& expected, int limit = 255);

/// What sets of mistakes draw of every scene of the kit. Equal pictures are stored once.
class Variants {
 public:
  /// All sets of at most `most` mistakes.
  Variants(int most, ThreadPool& pool);

  const std::vector<MistakeSet>& sets() const { return sets_; }
  const Picture8& picture(std::size_t scene, std::size_t set) const {
    return pictures_[scene][which_[scene][set]];
  }
  /// The fit of every set. Of those that do not match only `largest` is set.
  std::vector<Fit> fits(std::size_t scene, const Picture8& picture) const;

 private:
  std::vector<MistakeSet> sets_;
  std::vector<std::vector<std::uint32_t>> which_;  // scene, set: index of its picture
  std::vector<std::vector<Picture8>> pictures_;    // scene, different pictures
};

/// The pictures of a renderer, one per scene of the kit. Empty: there is none.
struct Submission {
  std::vector<Picture8> pictures;
  std::vector<std::string> problems;  ///< per scene: why its file is no picture of it; usually ""
};

/// Reads NAME.png of every scene. Throws Error(input) if `folder` has none of them.
Submission read_submission(const std::filesystem::path& folder);

enum class Result { passed, failed, missing };
inline constexpr const char* kResultNames[] = {"pass", "fail", "missing"};

struct SceneVerdict {
  Result result = Result::missing;
  std::string problem;  ///< the file's, if it is not a picture of the scene
  Fit fit;              ///< against the truth
  /// The smallest sets that draw this picture, best first. Several: this scene cannot distinguish
  /// them. Empty: no known mistake explains it.
  std::vector<MistakeSet> causes;
  double explained_psnr = 0;  ///< dB against the picture of the first cause
  /// Without causes: the set, of at most two, whose picture is closest, and its PSNR in dB. It
  /// explains nothing; it is a hint.
  MistakeSet closest = {};
  double closest_psnr = 0;
};

struct KitVerdict {
  std::vector<SceneVerdict> scenes;  ///< parallel to kit_scenes()
  /// The smallest sets that explain most scenes, also those that pass; best first. Several: the
  /// kit cannot distinguish them. Empty: all scenes pass, or no set explains more scenes than none.
  std::vector<MistakeSet> causes;
  std::size_t explained = 0;  ///< failed scenes that the first of `causes` draws

  std::size_t count(Result result) const;
};

/// `variants` has sets of at most two mistakes. If no two explain all pictures, further mistakes
/// are added one by one as long as each explains more of them.
KitVerdict judge_kit(const Submission& submission, const Variants& variants, ThreadPool& pool);

}  // namespace qs
