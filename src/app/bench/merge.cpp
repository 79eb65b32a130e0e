// SPDX-License-Identifier: MIT
#include "app/bench/merge.h"

#include <algorithm>
#include <cassert>
#include <set>
#include <tuple>

#include "raster/scene/fail.h"

namespace qs {

BenchReport merge_reports(std::span<const BenchReport> parts, bool mixed) {
  assert(!parts.empty());
  BenchReport merged = parts.front();
  for (const BenchReport& part : parts.subspan(1)) {
    const auto &a = merged.environment, &b = part.environment;
    const auto check = [&](const char* what, const std::string& one, const std::string& other) {
      if (!mixed && one != other) {
        fail("merge: the parts differ in {} ({} and {}): --mixed joins them all the same", what,
             one, other);
      }
    };
    check("device", measured_on(a), measured_on(b));
    check("backend", a.value("backend", ""), b.value("backend", ""));
    check("commit", a.value("commit", ""), b.value("commit", ""));
    check("scenes", merged.scenes.dump(), part.scenes.dump());
    merged.rows.insert(merged.rows.end(), part.rows.begin(), part.rows.end());
  }
  std::stable_sort(merged.rows.begin(), merged.rows.end(),
                   [](const BenchRow& a, const BenchRow& b) { return a.view < b.view; });
  std::set<std::tuple<std::uint64_t, std::string>> seen;
  for (const BenchRow& row : merged.rows) {
    if (!seen.emplace(row.view, row.mode).second) {
      fail("merge: {}, camera {}, {} was measured twice", row.scene, row.camera, row.mode);
    }
  }
  return merged;
}

}  // namespace qs
