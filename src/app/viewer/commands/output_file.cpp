// SPDX-License-Identifier: MIT
#include "app/viewer/commands/output_file.h"

#include "app/viewer/state/actions.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/replace_file.h"

namespace qs {

void save_results(RenderContext& context, const Viewer& viewer, const std::string& folder,
                  const std::string& stem,
                  const std::function<void(const std::filesystem::path& path)>& save,
                  const std::string& more) {
  const auto save_in = [=, &context](const std::filesystem::path& place) {
    const std::filesystem::path path = free_name(place / folder, stem, "");
    save(path);
    context.report(action::notify_file, path, more);
  };
  try {
    save_in(viewer.out_dir);
  } catch (const Error& error) {
    context.unsaved.push_back(save_in);
    context.report(action::results_kept, folder, std::string(error.what()));
  }
}

std::string keep_beside(const std::filesystem::path& scene, const std::string& ending, bool owns,
                        const std::string& work, const std::function<std::string()>& text) {
  const std::filesystem::path path = scene.string() + ending;
  try {
    if (!owns && is_there(path))
      std::filesystem::rename(path,
                              free_name(path.parent_path(), scene.filename().string(), ending));
    const std::string content = text();
    if (content.empty()) {
      std::filesystem::remove(path);
    } else {
      write_text(path, content);
    }
    return {};
  } catch (const std::exception& error) {
    return fmt::format("{}: the {} cannot be kept: {}", path.string(), work, error.what());
  }
}

OutputFile::OutputFile(const Viewer& viewer, const std::string& folder, const std::string& stem,
                       const std::string& ending) {
  if (viewer.is_remote) {
    work_.emplace();
    path_ = work_->path() / (stem + ending);
    return;
  }
  const std::filesystem::path place = viewer.out_dir / folder;
  std::error_code error;
  if (!std::filesystem::exists(place, error)) new_folder_ = place;
  make_folder(place);
  path_ = free_name(place, stem, ending);
  check_folder(path_);
}

OutputFile::~OutputFile() {
  std::error_code error;  // if it is not empty
  std::filesystem::remove(new_folder_, error);
}

void OutputFile::done(RenderContext& context, const std::string& more) const {
  if (!work_) return context.report(action::notify_file, path_, more);
  const MappedFile file(path_);
  const auto content = file.content();
  if (content.size() > kMostSent)
    fail("{}: {} are too many to send", path_.filename().string(), bytes_text(content.size()));
  context.report(&Host::send_file, path_.filename().string(),
                 std::make_shared<const std::string>(reinterpret_cast<const char*>(content.data()),
                                                     content.size()));
}

}  // namespace qs
