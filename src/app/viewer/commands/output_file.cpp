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

void keep_beside(const Viewer& viewer, Host& host, const KeptWork& work, const Action& then) {
  host.run([=, of = viewer.scene->path](RenderContext& context) {
    if (const Scene& scene = *context.session.scene; scene.path == of) {
      const std::filesystem::path path = of.string() + work.ending;
      std::string problem;
      try {
        if (!work.owns_file && is_there(path))
          std::filesystem::rename(
              path, free_name(path.parent_path(), of.filename().string(), work.ending));
        const std::string content = work.text(scene);
        content.empty() ? void(std::filesystem::remove(path)) : write_text(path, content);
      } catch (const std::exception& error) {
        problem =
            fmt::format("{}: the {} cannot be kept: {}", path.string(), work.name, error.what());
      }
      context.report(work.kept, problem);
    }
    if (then) context.report(then);
  });
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
