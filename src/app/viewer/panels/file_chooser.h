// SPDX-License-Identifier: MIT
//
// The state of the dialog Open, apart from its drawing: a folder, the typed text, and the row that
// the arrow keys select.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace qs {

struct FileEntry {
  std::filesystem::path path;
  std::string name;  ///< as it is listed: folders end with a slash
  bool folder = false;
  std::string size, date;  ///< empty if unknown
};

class FileChooser {
 public:
  /// Begins in a folder, with an empty text. If a folder is chosen, files are not listed.
  void start(const std::filesystem::path& folder, bool chooses_folder = false);

  /// Lists another folder and clears the typed text.
  void go_to(const std::filesystem::path& folder);

  /// The text of the path field changed. A text with a slash lists the folder that it names. The
  /// first row that matches a name is selected.
  void type(const std::string& text);

  /// Moves the selection among the rows, down if `by` is positive.
  void select(int by);

  /// Carries out Enter: opens the typed path if it exists and no arrow key was used, else the
  /// selected row, or lists it if it is a folder without a scene. Returns the path to open. If a
  /// folder is chosen, a selected row is listed, a typed folder is returned, and without both the
  /// listed folder.
  std::optional<std::filesystem::path> enter();

  /// Carries out a click on a row.
  std::optional<std::filesystem::path> choose(const FileEntry& entry);

  const std::filesystem::path& folder() const { return listed_; }
  /// entries that match the typed text
  const std::vector<FileEntry>& rows() const { return rows_; }
  int selected() const { return selected_; }  ///< index of a row, -1: none
  const std::string& typed() const { return typed_; }
  const std::string& problem() const { return problem_; }  ///< the reason why Enter had no effect
  int moves() const { return moves_; }  ///< counts go_to(): the field begins again

 private:
  std::filesystem::path typed_path() const;
  void list(const std::filesystem::path& folder);
  void filter();

  std::filesystem::path folder_;  // to which a typed path is relative
  std::filesystem::path listed_;
  std::vector<FileEntry> entries_, rows_;
  std::string typed_, problem_;
  bool chooses_folder_ = false;
  bool moved_ = false;  // the arrow keys chose the selected row
  int selected_ = -1, moves_ = 0;
};

}  // namespace qs
