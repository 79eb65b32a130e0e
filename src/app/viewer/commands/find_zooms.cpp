// SPDX-License-Identifier: MIT
//
// Finds the zooms of earlier sessions in the folder zoom of Viewer::out_dir.
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <vector>

#include "app/report/zoom_bundle.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/error.h"

namespace qs {
namespace {

constexpr std::ptrdiff_t kMostFound = 50;                            ///< the newest
constexpr std::uintmax_t kMostZoomBytes = std::uintmax_t{16} << 20;  ///< of a zoom.json

// The files zoom.json below `folder`, oldest first.
std::vector<std::filesystem::path> zoom_files(const std::filesystem::path& folder) {
  struct Dated {
    std::filesystem::file_time_type time;
    std::filesystem::path path;
  };
  std::vector<Dated> found;
  std::error_code error;
  for (std::filesystem::directory_iterator each(folder, error), end; !error && each != end;
       each.increment(error)) {
    const std::filesystem::path path = each->path() / "zoom.json";
    std::error_code unreadable;
    const std::uintmax_t bytes = std::filesystem::file_size(path, unreadable);
    const auto time = std::filesystem::last_write_time(path, unreadable);
    if (!unreadable && bytes <= kMostZoomBytes) found.push_back({time, path});
  }
  std::sort(found.begin(), found.end(), [](const Dated& a, const Dated& b) {
    return a.time != b.time ? a.time < b.time : a.path < b.path;
  });
  std::vector<std::filesystem::path> paths;
  for (const Dated& file : found) paths.push_back(file.path);
  if (std::ssize(paths) > kMostFound) paths.erase(paths.begin(), paths.end() - kMostFound);
  return paths;
}

void list_zooms(RenderContext& context, const Viewer& viewer) {
  std::vector<ZoomRecord> records;
  for (const std::filesystem::path& path : zoom_files(viewer.out_dir / "zoom")) {
    try {
      ZoomRecord record = make_zoom_record(read_zoom_json(path));
      record.folder = path.parent_path();
      std::error_code error;
      record.has_figures =
          std::filesystem::exists(record.folder / kZoomQuantities[0].figure, error);
      if (!record.rows.empty()) records.push_back(std::move(record));
    } catch (const Error&) {  // another program's file, or a damaged one
    }
  }
  context.report(action::zooms_found, std::move(records));
}

}  // namespace

void action::find_zooms(Viewer& viewer, Host& host) {
  if (viewer.zoom.searched) return;
  viewer.zoom.searched = true;
  start_job(viewer, host, list_zooms);
}

}  // namespace qs
