// SPDX-License-Identifier: MIT
#include "io/cloud/cloud_memory.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include <sys/mman.h>

namespace qs {

void prefer_huge_pages(void* memory, std::size_t bytes) {
  constexpr std::uintptr_t kPage = 4096, kHugePage = 2u << 20;
  if (bytes < 2 * kHugePage) return;
  const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + kPage - 1) / kPage * kPage;
  const auto end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / kPage * kPage;
  madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

std::uint64_t available_memory() {
  std::ifstream facts("/proc/meminfo");
  std::string name, unit;
  for (std::uint64_t kibibytes = 0; facts >> name >> kibibytes && std::getline(facts, unit);)
    if (name == "MemAvailable:") return kibibytes << 10;
  return std::numeric_limits<std::uint64_t>::max();
}

GaussianCloud make_cloud(std::size_t count, int sh_degree) {
  GaussianCloud cloud;
  cloud.resize(count, sh_degree);
  const auto advise = [](auto&... arrays) {
    (prefer_huge_pages(arrays.data(), arrays.size() * sizeof arrays[0]), ...);
  };
  advise(cloud.positions, cloud.log_scales, cloud.rotations, cloud.opacity_logits, cloud.sh);
  return cloud;
}

GaussianCloud with_sh_degree(GaussianCloud cloud, int degree) {
  if (degree >= cloud.sh_degree) return cloud;
  const auto before = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  const auto after = static_cast<std::size_t>(sh_coefficient_count(degree));
  Array<glm::vec3> sh(cloud.size() * after);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    std::copy_n(&cloud.sh[i * before], after, &sh[i * after]);
  cloud.sh = std::move(sh);
  cloud.sh_degree = degree;
  return cloud;
}

}  // namespace qs
