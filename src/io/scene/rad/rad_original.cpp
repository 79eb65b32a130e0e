// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad_original.h"

#include <array>
#include <bit>
#include <cstring>

#include "base/list_of.h"
#include "io/bytes/inflate.h"
#include "io/cloud/cloud_memory.h"

namespace qs {

void pack_original(const GaussianCloud& cloud, std::size_t i, std::uint32_t number,
                   std::span<std::uint32_t> words) {
  const glm::vec3& scale = cloud.log_scales[i];
  const glm::quat& q = cloud.rotations[i];
  const std::array values = {
      cloud.opacity_logits[i], scale.x, scale.y, scale.z, q.w, q.x, q.y, q.z};
  words[0] = number;
  std::memcpy(&words[1], values.data(), sizeof values);
  const float* const sh = &sh_of(cloud, i)->x;
  for (std::size_t k = values.size() + 1, v = 0; k < words.size(); ++k, ++v)
    words[k] = v < 3 * sh_count(cloud) ? std::bit_cast<std::uint32_t>(sh[v]) : 0;
}

RadOriginals::RadOriginals(const RadChunk& chunk) : words_(original_words(chunk.sh_degree())) {
  if (chunk.original.empty()) return;
  for (const std::uint32_t children : rad_integers(chunk, kRadChildCount))
    leaf_of_.push_back(children == 0 ? static_cast<std::uint32_t>(leaves_++) : ~0u);
  const std::string source = chunk.source + ": quadsplat: original";
  const std::size_t needed = words_ * leaves_ * sizeof(std::uint32_t);
  if (needed > kMaxInflation * chunk.original.size())
    fail("{}: {} bytes for {} leaves", source, chunk.original.size(), leaves_);
  Array<std::byte> bytes(needed);
  inflate_all(chunk.original, bytes, source);
  values_.resize(words_ * leaves_);
  for (std::size_t k = 0; k < words_; ++k)
    for (std::size_t i = 0; i < leaves_; ++i)
      for (std::size_t b = 0; b < 4; ++b)
        values_[k * leaves_ + i] |= static_cast<std::uint32_t>(bytes[(4 * k + b) * leaves_ + i])
                                    << 8 * b;
}

std::vector<std::uint32_t> RadOriginals::numbers() const {
  return list_of<std::uint32_t>(
      leaf_of_, [&](std::uint32_t leaf) { return leaf == ~0u ? kNoNumber : values_[leaf]; });
}

void RadOriginals::restore(std::span<const std::uint32_t> rows,
                           std::span<const std::uint32_t> places, GaussianCloud& cloud) const {
  for (std::size_t i = 0; i < rows.size() && !empty(); ++i) {
    if (leaf_of_[rows[i]] == ~0u) continue;
    const std::size_t place = places[i];
    std::size_t at = leaf_of_[rows[i]];
    const auto value = [&] { return std::bit_cast<float>(values_[at += leaves_]); };
    const auto triple = [&value](glm::vec3& to) {
      for (int axis = 0; axis < 3; ++axis) to[axis] = value();
    };
    cloud.opacity_logits[place] = value();
    triple(cloud.log_scales[place]);
    for (float* const part : {&cloud.rotations[place].w, &cloud.rotations[place].x,
                              &cloud.rotations[place].y, &cloud.rotations[place].z})
      *part = value();
    for (std::size_t k = 0; k < (words_ - 9) / 3; ++k) triple(sh_of(cloud, place)[k]);
  }
}

}  // namespace qs
