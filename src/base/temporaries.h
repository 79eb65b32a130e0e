// SPDX-License-Identifier: MIT
//
// The folders of unfinished work. A signal that ends the program deletes them.
#pragma once

#include <filesystem>
#include <functional>

#include "base/not_copied.h"

namespace qs {

/// A new, empty folder. The destructor deletes it with all that is left in it. Unfinished files
/// lie in such a folder, because a file that is opened after delete_temporaries() would come back;
/// in a folder that is gone it cannot be created.
class UnfinishedFolder : NotCopied {
 public:
  /// Six random characters complete the name. Throws std::filesystem::filesystem_error if the
  /// folder cannot be created.
  explicit UnfinishedFolder(const std::filesystem::path& beginning);
  ~UnfinishedFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// True if the file is in an unfinished folder.
bool is_unfinished(const std::filesystem::path& file);

/// Moves finished work to its place: delete_temporaries() waits until `move` is done.
void move_undisturbed(const std::function<void()>& move);

/// Deletes all of them for a program that ends now: afterwards every thread that creates or deletes
/// one waits for ever.
void delete_temporaries();

// A new folder among the system's temporary files. The destructor deletes it.

class WorkFolder : public UnfinishedFolder {
 public:
  /// Throws Error(input) if the folder cannot be created.
  WorkFolder();
};

}  // namespace qs
