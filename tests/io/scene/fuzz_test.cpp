// SPDX-License-Identifier: MIT
//
// The targets of scripts/fuzz, run on their seeds, which are files below tests/data, and on the
// inputs that fuzzers kept.
#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "fuzz/targets.h"
#include "io/camera/camera_formats.h"
#include "io/picture/picture_formats.h"
#include "io/scene/reader.h"
#include "support/corpus.h"
#include "support/shared.h"

namespace qs::test {
namespace {

std::vector<std::filesystem::path> seeds_of(const FuzzTarget& target) {
  std::vector<std::filesystem::path> seeds;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(source_path("tests/data"))) {
    if (!entry.is_regular_file()) continue;
    std::istringstream endings(target.ending);
    for (std::string ending; endings >> ending;) {
      if (entry.path().string().ends_with(ending)) {
        seeds.push_back(entry.path());
        break;
      }
    }
  }
  return seeds;
}

TEST(Fuzz, every_format_has_a_target) {
  std::set<std::string> names;
  for (const FuzzTarget& target : fuzz_targets())
    EXPECT_TRUE(names.insert(target.name).second) << target.name;
  const std::set<std::string> expected = {"ply",          "compressed_ply",
                                          "spz",          "splat",
                                          "ksplat",       "sog",
                                          "streamed_sog", "gltf",
                                          "cameras_bin",  "cameras_txt",
                                          "images_bin",   "images_txt",
                                          "jpg",          "png",
                                          "points3D_bin", "points3D_txt",
                                          "ppm",          "pfm",
                                          "npy",          "cameras_json",
                                          "webp",         "safetensors",
                                          "compact-3dgs", "pickle",
                                          "torch",        "array",
                                          "huffman",      "message",
                                          "sibr_request", "sibr_answer",
                                          "preferences",  "transforms_json",
                                          "usd",          "zipped_ply",
                                          "exif",         "points3D_ply",
                                          "rad",          "hier",
                                          "instances",    "rad_pages",
                                          "edits",        "cameras_xml",
                                          "measures"};
  EXPECT_EQ(names, expected);
}

TEST(Fuzz, every_target_has_seeds_and_reads_them_as_promised) {
  for (const FuzzTarget& target : fuzz_targets()) {
    const auto seeds = seeds_of(target);
    EXPECT_FALSE(seeds.empty()) << target.name;
    for (const auto& seed : seeds) {
      SCOPED_TRACE(target.name + ": " + seed.string());
      EXPECT_NO_THROW(target.run(file_bytes(seed)));
    }
  }
}

// scripts/fuzz keeps them in build/fuzz; a clean clone has none.
TEST(Fuzz, kept_inputs_are_read_as_promised) {
  for (const FuzzTarget& target : fuzz_targets()) {
    const std::filesystem::path kept = source_path("build/fuzz/corpus") / target.name;
    if (!std::filesystem::is_directory(kept)) continue;
    for (const auto& input : std::filesystem::directory_iterator(kept)) {
      SCOPED_TRACE(target.name + ": " + input.path().string());
      EXPECT_NO_THROW(target.run(file_bytes(input.path())));
    }
  }
}

}  // namespace
}  // namespace qs::test
