// SPDX-License-Identifier: MIT
#include "io/cloud/sh_degree.h"

#include <algorithm>
#include <utility>

namespace qs {

GaussianCloud with_sh_degree(GaussianCloud cloud, int degree) {
  if (degree >= cloud.sh_degree) return cloud;
  const auto before = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  const auto after = static_cast<std::size_t>(sh_coefficient_count(degree));
  Array<glm::vec3> sh(cloud.size() * after);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::copy_n(&cloud.sh[i * before], after, &sh[i * after]);
  }
  cloud.sh = std::move(sh);
  cloud.sh_degree = degree;
  return cloud;
}

}  // namespace qs
