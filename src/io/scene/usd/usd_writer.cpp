// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <ostream>
#include <string>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "io/bytes/replace_file.h"
#include "io/bytes/zip.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/usd/usd.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

using Text = fmt::memory_buffer;
using Sink = std::function<void(std::string_view text)>;

template <class... Args>
void put(Text& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

void put_triple(Text& text, const glm::vec3& v) { put(text, "({}, {}, {})", v.x, v.y, v.z); }

glm::vec3 linear_scale(const GaussianCloud& cloud, std::size_t i) {
  return glm::exp(glm::dvec3(cloud.log_scales[i]));
}

// The box of all Gaussians' three standard deviations.
std::string extent_of(const GaussianCloud& cloud) {
  constexpr float kReach = 3;
  glm::vec3 low(std::numeric_limits<float>::infinity()), high = -low;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 scale = linear_scale(cloud, i);
    const float reach = kReach * std::max({scale.x, scale.y, scale.z});
    low = glm::min(low, cloud.positions[i] - reach);
    high = glm::max(high, cloud.positions[i] + reach);
  }
  return fmt::format("[({}, {}, {}), ({}, {}, {})]", low.x, low.y, low.z, high.x, high.y, high.z);
}

// A list with one line for each Gaussian.
struct GaussianList {
  const char* declaration;
  std::function<void(Text& text, std::size_t i)> put_values;
  std::string metadata = {};

  void write(std::size_t count, const Sink& sink) const {
    constexpr std::size_t kPiece = 1 << 20;
    Text text;
    put(text, "        {} = [\n", declaration);
    for (std::size_t i = 0; i < count; ++i) {
      put_values(text, i);
      put(text, "{}", i + 1 < count ? ",\n" : "\n");
      if (text.size() < kPiece) continue;
      sink({text.data(), text.size()});
      text.clear();
    }
    put(text, "        ]{}\n", metadata);
    sink({text.data(), text.size()});
  }
};

void write_stage(const GaussianCloud& rdf_cloud, const Progress& progress, const Sink& sink) {
  GaussianCloud cloud = rdf_cloud;
  flip_axes(cloud, 0, cloud.size(), kTurnAboutX);
  const std::size_t coefficients = sh_count(cloud);
  const GaussianList lists[] = {
      {"point3f[] positions", [&](Text& text, auto i) { put_triple(text, cloud.positions[i]); }},
      {"quatf[] orientations",
       [&](Text& text, auto i) {
         const glm::quat& q = cloud.rotations[i];
         put(text, "({}, {}, {}, {})", q.w, q.x, q.y, q.z);
       }},
      {"float3[] scales", [&](Text& text, auto i) { put_triple(text, linear_scale(cloud, i)); }},
      {"float[] opacities",
       [&](Text& text, auto i) {
         put(text, "{}", static_cast<float>(opacity_of_logit(cloud.opacity_logits[i])));
       },
       fmt::format("\n        uniform int radiance:sphericalHarmonicsDegree = {}",
                   cloud.sh_degree)},
      {"float3[] radiance:sphericalHarmonicsCoefficients",
       [&](Text& text, auto i) {
         for (std::size_t k = 0; k < coefficients; ++k) {
           if (k > 0) put(text, ", ");
           put_triple(text, sh_of(cloud, i)[k]);
         }
       },
       fmt::format(
           " (\n            elementSize = {}\n            interpolation = \"vertex\"\n        )",
           coefficients)}};
  sink(
      fmt::format("#usda 1.0\n(\n    defaultPrim = \"World\"\n    doc = \"written by quadsplat\"\n"
                  "    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\ndef Xform \"World\"\n{{\n"
                  "    def ParticleField3DGaussianSplat \"Splats\"\n    {{\n"
                  "        float3[] extent = {}\n",
                  extent_of(cloud)));
  float done = 0;
  for (const GaussianList& list : lists) {
    progress.update(done);
    list.write(cloud.size(), sink);
    done += 0.1f;
  }
  sink(
      "        uniform token projectionModeHint = \"perspective\"\n"
      "        uniform token sortingModeHint = \"zDepth\"\n    }\n}\n");
  progress.update(0.9f);
}

}  // namespace

void write_usda(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool&,
                const Progress& progress) {
  write_file(path, [&](std::ostream& file) {
    write_stage(cloud, progress, [&](std::string_view text) { file << text; });
  });
  progress.update(1);
}

void write_usdz(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool&,
                const Progress& progress) {
  std::vector<ZipEntry> files = {{"scene.usda", {}}};
  write_stage(cloud, progress, [&](std::string_view text) { files[0].content += text; });
  write_zip(path, files, ZipForm::aligned);
  progress.update(1);
}

}  // namespace qs
