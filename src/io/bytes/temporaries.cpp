// SPDX-License-Identifier: MIT
#include "io/bytes/temporaries.h"

#include <mutex>
#include <set>
#include <system_error>
#include <utility>

namespace qs {
namespace {

std::mutex temporaries_mutex;
// Never destroyed: the program may end while another thread uses it.
std::multiset<std::filesystem::path>& all_temporaries() {
  static auto* const all = new std::multiset<std::filesystem::path>;
  return *all;
}

}  // namespace

TemporaryPath::TemporaryPath(std::filesystem::path path) : path_(std::move(path)) {
  const std::lock_guard lock(temporaries_mutex);
  all_temporaries().insert(path_);
}

TemporaryPath::~TemporaryPath() {
  const std::lock_guard lock(temporaries_mutex);
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  all_temporaries().erase(all_temporaries().find(path_));
}

bool is_in_temporary(const std::filesystem::path& file) {
  const std::lock_guard lock(temporaries_mutex);
  for (auto path = file.parent_path(); path.has_relative_path(); path = path.parent_path())
    if (all_temporaries().contains(path)) return true;
  return false;
}

void move_undisturbed(const std::function<void()>& move) {
  const std::lock_guard lock(temporaries_mutex);
  move();
}

void delete_temporaries() {
  temporaries_mutex.lock();  // for ever
  std::error_code ignored;
  for (const std::filesystem::path& path : all_temporaries())
    std::filesystem::remove_all(path, ignored);
}

}  // namespace qs
