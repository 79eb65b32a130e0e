// SPDX-License-Identifier: MIT
//
// The hidden files and folders of unfinished work. A signal that ends the program deletes them.
#pragma once

#include <filesystem>
#include <functional>

namespace qs {

/// A file or folder that the destructor deletes, unless it was moved away or kept.
class TemporaryPath {
 public:
  explicit TemporaryPath(std::filesystem::path path);
  ~TemporaryPath();
  TemporaryPath(const TemporaryPath&) = delete;
  TemporaryPath& operator=(const TemporaryPath&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// True if the file is in a temporary folder.
bool is_in_temporary(const std::filesystem::path& file);

/// Moves finished work to its place: delete_temporaries() waits until `move` is done.
void move_undisturbed(const std::function<void()>& move);

/// Deletes all of them for a program that ends now: afterwards every thread that creates or deletes
/// one waits for ever.
void delete_temporaries();

}  // namespace qs
