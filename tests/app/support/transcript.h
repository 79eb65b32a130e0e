// SPDX-License-Identifier: MIT
//
// Runs commands in this process, in a folder with a small scene, and keeps their output and files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

namespace qs::test {

/// The output of commands, with every time, name and version of this machine masked as #. While the
/// object lives, the current folder is a new folder that holds scene.ply, cameras.json with three
/// cameras (48 x 32, 40 x 56, 64 x 20), images/ with photographs of the first two, and
/// alone/scene.ply without cameras. There is no gnuplot.
class Transcript {
 public:
  Transcript();
  ~Transcript();
  Transcript(const Transcript&) = delete;
  Transcript& operator=(const Transcript&) = delete;

  /// From now on `gnuplot` is a shell script that runs these commands; $1 is the plot's script.
  void install_gnuplot(const std::string& commands);

  /// Runs "COMMAND WORDS..."; words are separated by spaces, and '' is an empty word. Frames are
  /// rendered on the CPU.
  /// Appends the command line, stdout, stderr (with "! " in front of each line) and an exit code
  /// other than 0.
  enum class Errors { kept, shown };  ///< of stderr: in the transcript, or where it was before
  void run(const std::string& command_line, Errors errors = Errors::kept);

  /// Appends a text file, or for a picture its size, mean colour, centre of brightness and
  /// metadata.
  void show(const std::string& file);

  const std::string& text() const { return text_; }

 private:
  std::string masked(std::string text) const;

  TemporaryFolder folder_;
  std::filesystem::path before_;
  std::string path_variable_, text_;
};

}  // namespace qs::test
