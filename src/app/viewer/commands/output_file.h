// SPDX-License-Identifier: MIT
//
// Names of the files that commands write. The file of a job stays below Viewer::out_dir, or is sent
// to a user at another machine and leaves no trace here.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "app/viewer/render/render_context.h"
#include "base/not_copied.h"
#include "base/temporaries.h"

namespace qs {

/// FOLDER/STEM_0001ENDING with the first number whose file does not exist yet.
inline std::filesystem::path free_name(const std::filesystem::path& folder, const std::string& stem,
                                       const std::string& ending) {
  std::filesystem::path path;
  std::error_code error;
  for (int n = 1; path.empty() || std::filesystem::exists(path, error); ++n)
    path = folder / fmt::format("{}_{:04}{}", stem, n, ending);
  return path;
}

/// "camera3" at a camera of the data set, else "view".
inline std::string camera_name(const Viewer& viewer) {
  return viewer.dataset_camera >= 0 ? fmt::format("camera{}", viewer.dataset_camera) : "view";
}

/// Calls save() with the name of a new folder, FOLDER/STEM_0001, and reports the folder. Results
/// that cannot be written stay in memory with `save`, and the window offers another place.
void save_results(RenderContext& context, const Viewer& viewer, const std::string& folder,
                  const std::string& stem,
                  const std::function<void(const std::filesystem::path& path)>& save,
                  const std::string& more = "");

/// Work of the user that a file beside the scene keeps, SCENE and the ending.
struct KeptWork {
  std::string ending, name;
  bool owns_file = false;                         ///< else a file there gets another name first
  std::function<std::string(const Scene&)> text;  ///< if it is empty, there is no file
  void (*kept)(Viewer& viewer, const std::string& problem);  ///< "": it could be written
};
/// Writes that file if the scene is still shown, then runs an action, which may be null.
void keep_beside(const Viewer& viewer, Host& host, const KeptWork& work, const Action& then);

class OutputFile : NotCopied {
 public:
  /// The largest file that is sent, bytes.
  static constexpr std::uintmax_t kMostSent = std::uintmax_t{256} << 20;

  /// FOLDER/STEM_0001ENDING with the first free number; `folder` is below Viewer::out_dir and is
  /// created. Throws Error(input) if it cannot be written.
  OutputFile(const Viewer& viewer, const std::string& folder, const std::string& stem,
             const std::string& ending);
  /// Removes the folder if it was created for this file and is empty.
  ~OutputFile();

  /// The file to write.
  const std::filesystem::path& path() const { return path_; }

  /// The file is complete: reports it, with `more` behind its name, or sends it. Throws
  /// Error(input) if it is too large to be sent.
  void done(RenderContext& context, const std::string& more) const;

 private:
  std::optional<WorkFolder> work_;
  std::filesystem::path path_, new_folder_;
};

}  // namespace qs
