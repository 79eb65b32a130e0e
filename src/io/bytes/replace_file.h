// SPDX-License-Identifier: MIT
//
// Writes a file so that it appears whole or not at all: the content is written to a file of the
// same name in a hidden folder (temporaries.h) beside it, which is moved at the end, and deleted on
// failure. The content is on the disk before the file is moved, and the move before the function
// returns, so a loss of power leaves the old file or the new one. file_guard.h has the rule that
// says which existing files may be replaced.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <iosfwd>
#include <optional>
#include <string>

#include "base/descriptor.h"

namespace qs {

using WriteFiles = std::function<void(const std::filesystem::path& temporary)>;
using WriteStream = std::function<void(std::ostream& stream)>;

/// Calls write(temporary) and moves the written file to `path`. A symbolic link is followed: its
/// target is replaced. Anything but a regular file, such as /dev/stdout or a pipe, is written
/// directly. Throws what `write` throws, and Error(input) when the folder does not exist or the
/// file cannot be moved to it.
void replace_file(const std::filesystem::path& path, const WriteFiles& write);

/// Calls write(temporary) with an empty folder, and moves the files that it wrote there to
/// `folder`, which is created with its parents if needed: all files or none. Other files of
/// `folder` stay. Throws what `write` throws, with `folder` in the place of the temporary folder in
/// messages, and as replace_file().
void replace_folder(const std::filesystem::path& folder, const WriteFiles& write);

/// Runs work() and names `shown` instead of `hidden` in the message of its Error.
void naming(const std::filesystem::path& shown, const std::filesystem::path& hidden,
            const std::function<void()>& work);

/// Throws Error unless a command may write all these results: their folders exist, no two have the
/// same name, and file_guard.h allows each. Long commands ask before they work. Unset names and "-"
/// are allowed.
void check_targets(std::initializer_list<std::optional<std::filesystem::path>> files);

/// Throws Error(input) if no folder of this name can be written, because the name is a file's or
/// the folder above does not allow it.
void check_folder(const std::filesystem::path& folder);

/// Creates a folder and its parents. Throws Error(input).
void make_folder(const std::filesystem::path& folder);

/// As replace_file(), for a binary stream. Also throws Error(input) if it cannot be opened
/// or the disk is full.
void write_file(const std::filesystem::path& path, const WriteStream& write);

/// Throws Error(input) "PATH: cannot be written: ..." with the reason that errno gives and the
/// bytes that were written to `file`. `path` is the name to show.
[[noreturn]] void fail_to_write(const std::filesystem::path& path,
                                const std::filesystem::path& file);

/// Lets one process at a time write into a folder. The kernel holds the lock (flock on the folder
/// itself), so nothing is left when the process ends, not even after kill -9.
class FolderLock {
 public:
  /// Locks an existing folder until the destructor runs. Throws Error(usage) "PATH: WHO" if another
  /// lock exists, in this process or another: `who` says who has it.
  FolderLock(const std::filesystem::path& folder, const char* who);

  /// False: the file system cannot lock folders, so nothing is locked.
  bool held() const { return static_cast<bool>(folder_); }

 private:
  Descriptor folder_;
};

/// Writes the text to a file, or to stdout if the path is "-". Throws Error(input).
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace qs
