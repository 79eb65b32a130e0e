// SPDX-License-Identifier: MIT
//
// One libFuzzer program per row of readers(): the bytes go straight to the reader QUADSPLAT_READER.
// Whatever they are, it ends in a scene that keeps the cloud's promises or in an Error with one
// sentence. scripts/fuzz builds and runs all of them, with the corpus as seeds.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/scene/reader.h"
#include "raster/base/error.h"
#include "support/gzip.h"
#include "test_paths.h"

namespace qs {
namespace {

// Readers of several files find the others of a sound scene beside the one that is fuzzed.
std::filesystem::path path_for(std::string_view reader) {
  const std::filesystem::path valid = QUADSPLAT_SOURCE_DIR "/tests/data/corpus/valid";
  if (reader == "sog") return valid / "sog_v1_folder/meta.json";
  if (reader == "streamed sog") return valid / "lod_of_sog_v1/lod-meta.json";
  return valid / "fuzzed";
}

void demand(bool promise, const char* what) {
  if (promise) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

void check(const Scene& scene) {
  const GaussianCloud& cloud = scene.cloud;
  demand(!cloud.empty(), "a cloud is not empty");
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  demand(cloud.sh.size() == cloud.size() * coefficients, "SH fit the degree");
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3& p = cloud.positions[i];
    demand(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "positions are finite");
    const glm::quat& q = cloud.rotations[i];
    demand(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-3f, "unit rotations");
    demand(!std::isnan(cloud.opacity_logits[i]), "opacities are numbers");
    demand(cloud.log_scales[i].x < 100, "scales are finite");
  }
}

void read(const ReaderRow& reader, std::span<const std::byte> content) {
  static ThreadPool pool(1);
  Scene scene;
  scene.path = path_for(reader.name);
  try {
    reader.read(content, scene.path, pool, {}, scene);
    check(scene);
  } catch (const Error& error) {
    const std::string_view sentence = error.what();
    demand(sentence.starts_with(scene.path.string()), "a sentence names the file");
    demand(sentence.find('\n') == sentence.npos, "one sentence is one line");
  }
}

}  // namespace
}  // namespace qs

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // Fresh memory of exactly this size: reading one byte too many is seen.
  const std::vector<std::byte> content(reinterpret_cast<const std::byte*>(data),
                                       reinterpret_cast<const std::byte*>(data) + size);
  for (const qs::ReaderRow& reader : qs::readers()) {
    if (std::string_view(reader.name) != QUADSPLAT_READER) continue;
    reader.recognises(content, "fuzzed");
    qs::read(reader, content);
    // Below the checksum of gzip, which changed bytes would hardly ever pass.
    if (reader.name == std::string_view("spz")) qs::read(reader, qs::test::gzip(content, 1));
    return 0;
  }
  std::abort();  // the table has no such row
}
