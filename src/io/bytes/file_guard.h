// SPDX-License-Identifier: MIT
//
// The rule for the files that a command writes (docs/commands.md): never onto an input, and onto an
// existing file only if this program wrote it as a picture or a report, or with --overwrite. All
// files are written by replace_file() and replace_folder(), which ask this rule, so no writer can
// forget it. Functions that open a file call note_input().
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "base/not_copied.h"

namespace qs {

/// The threads for which a guard holds: all of them, or only its maker, as for a call of
/// libquadsplat. A thread with a guard of its own does not see the process's.
enum class GuardScope { process, thread };

/// The rule holds while an object exists, one at a time in a scope. Without one, such as in the
/// window, which gives its files new names, every file may be written.
class FileGuard : NotCopied {
 public:
  /// `overwrite`: existing files may be replaced, except inputs. `option`: its name in messages.
  explicit FileGuard(bool overwrite, std::string option = "--overwrite",
                     GuardScope scope = GuardScope::process);
  ~FileGuard();

  /// Number of files of earlier runs that were replaced.
  std::size_t replaced() const;

 private:
  GuardScope scope_;
};

/// The files that the current guard has seen.
struct WrittenFiles {
  std::size_t count = 0;
  std::filesystem::path last;
};
WrittenFiles written_files();

/// True without a guard, or if its `overwrite` is.
bool may_overwrite();

/// The command reads this file. Any thread may call it; the guard of a thread does not see other
/// threads.
void note_input(const std::filesystem::path& path);

/// This file belongs to the command, which may replace it although it also reads it. For a folder
/// this holds for all files in it that are not inputs.
void note_own(const std::filesystem::path& path);

/// Throws Error(usage) if the rule forbids writing this file. Returns true if writing replaces a
/// file of an earlier run. Long commands call it before their work. "-" is allowed.
bool check_target(const std::filesystem::path& path);

/// The file was written. `replaced`: what check_target() returned before.
void note_written(const std::filesystem::path& path, bool replaced);

/// For films and models as folders: throws Error(usage) unless the folder is missing or empty, or
/// `overwrite` is true.
void require_new_folder(const std::filesystem::path& folder, bool overwrite);

/// The first of NAME.json, NAME_0001.json, NAME_0002.json, ... that does not exist or
/// is_own_report().
std::filesystem::path own_name(const std::filesystem::path& path);

/// True if the file says that this program wrote it as a picture or a part of a report: pictures by
/// the text `Software`, reports by their first lines. Scenes, films and formats that cannot say it
/// (.ppm, .pfm, .npy) never do.
bool is_own_report(const std::filesystem::path& path);

}  // namespace qs
