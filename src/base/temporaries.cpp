// SPDX-License-Identifier: MIT
#include "base/temporaries.h"

#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <set>
#include <string>
#include <system_error>

#include "base/fail.h"

namespace qs {
namespace {

std::mutex temporaries_mutex;
// Never destroyed: the program may end while another thread uses it.
std::set<std::filesystem::path>& all_temporaries() {
  static auto* const all = new std::set<std::filesystem::path>;
  return *all;
}

// Another thread may create a file while the folder is emptied: the folder is then emptied again.
// The tries are bounded, because NFS keeps open files under another name.
void delete_folder(const std::filesystem::path& folder) {
  std::error_code error = std::make_error_code(std::errc::directory_not_empty);
  for (int tries = 0; tries < 100 && error == std::errc::directory_not_empty; ++tries)
    std::filesystem::remove_all(folder, error);
}

}  // namespace

UnfinishedFolder::UnfinishedFolder(const std::filesystem::path& beginning) {
  std::string name = beginning.string() + "XXXXXX";
  const std::lock_guard lock(temporaries_mutex);
  if (mkdtemp(name.data()) == nullptr) {
    const std::error_code reason(errno, std::generic_category());
    throw std::filesystem::filesystem_error("mkdtemp", name, reason);
  }
  path_ = name;
  all_temporaries().insert(path_);
}

UnfinishedFolder::~UnfinishedFolder() {
  const std::lock_guard lock(temporaries_mutex);
  delete_folder(path_);
  all_temporaries().erase(path_);
}

bool is_unfinished(const std::filesystem::path& file) {
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
  for (const std::filesystem::path& folder : all_temporaries()) delete_folder(folder);
}

WorkFolder::WorkFolder() try
    : UnfinishedFolder(std::filesystem::temp_directory_path() / "quadsplat-") {
} catch (const std::filesystem::filesystem_error& error) {
  fail("{}: no temporary folder can be created: {}", error.path1().string(),
       error.code().message());
}

}  // namespace qs
