// SPDX-License-Identifier: MIT
#include "io/scene/usd/usd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/fail.h"
#include "base/progress_bar.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_source.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/linear_values.h"
#include "io/scene/ply/ply.h"
#include "io/scene/usd/usd_stage.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

constexpr std::string_view kTextStart = "#usda ", kCrateStart = "PXR-USDC";
constexpr float kParsed = 0.6f;  // share of the progress

constexpr std::array<const char*, kUsdArrays> kArrayNames = {"positions", "orientations", "scales",
                                                             "opacities", "spherical harmonics"};

// The arrays of a prim that fit the number of its positions.
class SplatArrays {
 public:
  SplatArrays(UsdSplats& splats, const glm::dmat4& rdf_from_stage, const std::string& source,
              Scene& scene)
      : splats_(splats), count_(splats.count()) {
    if (splats.values[kUsdSh])
      degree_ = kept_sh_degree(sh_coefficient_count(splats.sh_degree) - 1, scene);
    stored_sh_ = static_cast<std::size_t>(sh_coefficient_count(splats.sh_degree));
    const std::size_t sizes[kUsdArrays] = {3, 4, 3, 1, 3 * stored_sh_};
    for (std::size_t i = 0; i < kUsdArrays; ++i) {
      auto& values = splats.values[i];
      if (!values || values->size() == count_ * sizes[i]) continue;
      const bool is_short = values->size() < count_ * sizes[i];
      scene.warn("{}: {} {} are stored for {} Gaussians; {}.", splats.prim,
                 static_cast<double>(values->size()) / static_cast<double>(sizes[i]),
                 kArrayNames[i], count_,
                 is_short ? "they were ignored, as OpenUSD defines" : "the rest was ignored");
      if (is_short) values.reset();
    }
    if (!splats.values[kUsdSh]) degree_ = 0;
    const glm::dmat4& m = splats.world;
    if (!Transform::is_invertible(m) || !std::isfinite(m[3].x + m[3].y + m[3].z))
      fail("{}: {}: its transform cannot be applied: it flattens or distorts space", source,
           splats.prim);
    if (rdf_from_stage * m != glm::dmat4(1))
      transform_ = std::make_unique<Transform>(rdf_from_stage * m);
    if (transform_ && !transform_->is_similarity())
      scene.warn("{} stretches or mirrors its Gaussians; their covariances were transformed.",
                 splats.prim);
  }

  std::size_t count() const { return count_; }
  int degree() const { return degree_; }

  void fill(std::size_t from, GaussianCloud& cloud, std::size_t to, LinearValues& linear) const {
    cloud.positions[to] = triple(kUsdPositions, from, 0);
    cloud.rotations[to] =
        glm::quat(value(kUsdRotations, 4 * from, 1), value(kUsdRotations, 4 * from + 1, 0),
                  value(kUsdRotations, 4 * from + 2, 0), value(kUsdRotations, 4 * from + 3, 0));
    cloud.log_scales[to] = linear.log_scale(triple(kUsdScales, from, 1));
    cloud.opacity_logits[to] = linear.logit(static_cast<double>(value(kUsdOpacities, from, 1)));
    glm::vec3* const sh = sh_of(cloud, to);
    std::fill_n(sh, sh_count(cloud), glm::vec3(0));
    for (std::size_t k = 0; k < static_cast<std::size_t>(sh_coefficient_count(degree_)); ++k)
      sh[k] = triple(kUsdSh, from * stored_sh_ + k, 0);
    if (transform_) transform_->apply(cloud, to);
  }

 private:
  float value(UsdArray array, std::size_t at, float otherwise) const {
    const auto& values = splats_.values[array];
    return values ? (*values)[at] : otherwise;
  }
  glm::vec3 triple(UsdArray array, std::size_t i, float otherwise) const {
    return {value(array, 3 * i, otherwise), value(array, 3 * i + 1, otherwise),
            value(array, 3 * i + 2, otherwise)};
  }

  const UsdSplats& splats_;
  std::size_t count_ = 0, stored_sh_ = 1;
  int degree_ = 0;
  std::unique_ptr<Transform> transform_;  // null: identity
};

}  // namespace

bool recognises_usd(ByteSpan content, const std::filesystem::path& path) {
  return text_of(content).starts_with(kTextStart) || text_of(content).starts_with(kCrateStart) ||
         is_usdz(content) || (is_zip(content) && path.extension() == ".usdz");
}

void read_usd(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  std::string source = path.string();
  const bool zipped = is_zip(content);
  Array<std::byte> unpacked;
  if (zipped) {
    const std::string stage(first_name_in_zip(content));
    if (!is_usdz(content))
      fail("{}: the first file of a .usdz is its stage, but here it is '{}'", source,
           printable(stage));
    unpacked = files_in_zip(content, path, stage)->read(stage, content.size());
    content = unpacked;
    source += ": " + printable(stage);
  }
  if (text_of(content).starts_with(kCrateStart))
    fail(
        "{}: binary .usdc (crate), of which only the text form can be read; `usdcat` of OpenUSD "
        "writes it as .usda",
        source);
  if (!text_of(content).starts_with(kTextStart)) fail("{}: does not begin with #usda", source);
  UsdStage stage = parse_usda(text_of(content), source, part_of(options.progress, 0, kParsed));
  scene.axes = stage.z_is_up ? "RFU" : "RUB";
  scene.format = zipped ? "usd, text in a zip" : "usd, text";
  scene.warnings = std::move(stage.warnings);

  // RUB and RDF have parallel axes, so that signs convert them without rounding.
  const glm::dmat4 turn = stage.z_is_up ? glm::dmat4(rdf_from(scene.axes)) : glm::dmat4(1);
  const AxisSigns signs = stage.z_is_up ? AxisSigns() : kTurnAboutX;
  std::vector<SplatArrays> parts;
  parts.reserve(stage.splats.size());
  CloudParts rows;
  int degree = 0;
  for (UsdSplats& splats : stage.splats) {
    parts.emplace_back(splats, turn, source, scene);
    rows.add(parts.back().count());
    degree = std::max(degree, parts.back().degree());
  }
  if (rows.count() == 0)
    fail("{}: no prim of type ParticleField3DGaussianSplat {}{}", source,
         parts.empty() ? "is shown" : "has positions",
         scene.warnings.empty() ? "" : ". " + scene.warnings.back());
  scene.cloud = make_cloud(rows.count(), degree);
  LinearValues linear;
  fill_cloud(scene, pool, options.progress, kParsed, [&](std::size_t begin, std::size_t end) {
    rows.for_range(begin, end, [&](std::size_t part, std::uint64_t row, std::size_t i) {
      parts[part].fill(row, scene.cloud, i, linear);
    });
    flip_axes(scene.cloud, begin, end, signs);
  });
  linear.warn(scene);
}

}  // namespace qs
