// SPDX-License-Identifier: MIT
//
// A file that a job writes for the user: it stays below Viewer::out_dir, or is sent to a user at
// another machine and leaves no trace here.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/report/work_folder.h"
#include "app/viewer/render/render_context.h"

namespace qs {

class OutputFile {
 public:
  /// The largest file that is sent, bytes.
  static constexpr std::uintmax_t kMostSent = std::uintmax_t{256} << 20;

  /// FOLDER/STEM_0001ENDING with the first free number; `folder` is below Viewer::out_dir and is
  /// created. Throws Error(input).
  OutputFile(const Viewer& viewer, const std::string& folder, const std::string& stem,
             const std::string& ending);

  /// The file to write.
  const std::filesystem::path& path() const { return path_; }

  /// The file is complete: reports it, with `more` behind its name, or sends it. Throws
  /// Error(input) if it is too large to be sent.
  void done(RenderContext& context, const std::string& more) const;

 private:
  std::optional<WorkFolder> work_;
  std::filesystem::path path_;
};

namespace action {

/// Hands a file to Host::send_file().
void send_file(Viewer& viewer, Host& host, const std::string& name,
               const std::shared_ptr<const std::string>& bytes);

}  // namespace action
}  // namespace qs
