// SPDX-License-Identifier: MIT
#include "io/bytes/file_guard.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <sys/stat.h>

#include "base/fail.h"
#include "base/path_kind.h"
#include "io/bytes/byte_text.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

// A file under any name: a link, a hard link or another spelling.
using FileId = std::pair<dev_t, ino_t>;

std::optional<FileId> id_of(const fs::path& path) {
  struct stat status = {};
  if (stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileId{status.st_dev, status.st_ino};
}

struct GuardState {
  bool overwrite = false;
  std::string option;  // that allows it
  std::map<FileId, fs::path> inputs;
  std::map<FileId, fs::path> own;
  std::vector<fs::path> own_folders;
  std::size_t replaced = 0;
  WrittenFiles written;
};

std::mutex guard_mutex;
std::optional<GuardState> process_guard;
thread_local std::optional<GuardState> thread_guard;

// The guard that holds for the calling thread, if any.
std::optional<GuardState>& current() { return thread_guard ? thread_guard : process_guard; }

std::optional<GuardState>& guard_of(GuardScope scope) {
  return scope == GuardScope::thread ? thread_guard : process_guard;
}

// The number of a file that was deleted may belong to another file now.
bool holds_file(const std::map<FileId, fs::path>& files, const FileId& id) {
  const auto found = files.find(id);
  return found != files.end() && id_of(found->second) == id;
}

bool is_own(const fs::path& path, const FileId& id) {
  if (holds_file(current()->own, id)) return true;
  std::error_code error;
  const fs::path place = fs::weakly_canonical(path, error);
  return std::any_of(current()->own_folders.begin(), current()->own_folders.end(),
                     [&](const fs::path& folder) {
                       const fs::path inside = place.lexically_relative(folder);
                       return !inside.empty() && *inside.begin() != "..";
                     });
}

// A text in the first or last bytes of a file by which this program recognises its own files.
struct FileMark {
  std::string_view ending, text;
};
using namespace std::string_view_literals;
constexpr FileMark kFileMarks[] = {
    {".png", "tEXtSoftware\0quadsplat"sv},
    {".exr", "quadsplat"sv},
    {".tif", "quadsplat"sv},
    {".jpg", "quadsplat"sv},
    {".html", "<meta name=\"generator\" content=\"quadsplat"sv},
    {".md", "<!-- written by quadsplat bench -->"sv},
    {".gp", ".gp` in this folder\nset encoding utf8\n"sv},
    {".json", "\"build_type\": "sv},
    {".json", "\"written_by\": \"quadsplat\""sv},
    {".json", "\"larger_than_the_scene\": "sv},
    {".json", "\"transmittance\": "sv},
    {".json", "LDR-FLIP at 67.02 pixels per degree"sv},
    {".json", "\"tolerance\": {\n    \"largest_difference\": "sv},
    {".csv", "scene,camera,mode,pipeline,"sv},
    {".csv", "scene,camera,mode,backend,gaussians,"sv},
    {".csv", "truth,judged,view,width,height,psnr,"sv},
    {".csv", "scene,camera,distance,share_of,"sv},
};

bool holds(const fs::path& path, const std::string& ending) {
  constexpr std::streamsize kBytes = 4096;
  std::string text(2 * kBytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), kBytes);
  std::streamsize bytes = file.gcount();
  if (bytes == kBytes) {
    file.seekg(-kBytes, std::ios::end);
    file.read(text.data() + bytes, kBytes);
    bytes += file.gcount();
  }
  text.resize(static_cast<std::size_t>(bytes));
  return std::any_of(std::begin(kFileMarks), std::end(kFileMarks), [&](const FileMark& mark) {
    return mark.ending == ending && text.find(mark.text) != std::string::npos;
  });
}

}  // namespace

FileGuard::FileGuard(bool overwrite, std::string option, GuardScope scope) : scope_(scope) {
  const std::lock_guard lock(guard_mutex);
  guard_of(scope).emplace().overwrite = overwrite;
  guard_of(scope)->option = std::move(option);
}

FileGuard::~FileGuard() {
  const std::lock_guard lock(guard_mutex);
  guard_of(scope_).reset();
}

std::size_t FileGuard::replaced() const {
  const std::lock_guard lock(guard_mutex);
  return guard_of(scope_)->replaced;
}

WrittenFiles written_files() {
  const std::lock_guard lock(guard_mutex);
  return current() ? current()->written : WrittenFiles();
}

bool may_overwrite() {
  const std::lock_guard lock(guard_mutex);
  return !current() || current()->overwrite;
}

void note_input(const fs::path& path) {
  const std::lock_guard lock(guard_mutex);
  if (!current()) return;
  if (const auto id = id_of(path); id && !holds_file(current()->own, *id))
    current()->inputs[*id] = fs::absolute(path);
}

void note_own(const fs::path& path) {
  const std::lock_guard lock(guard_mutex);
  std::error_code error;
  if (!current()) return;
  if (fs::is_directory(path, error)) {
    current()->own_folders.push_back(fs::weakly_canonical(path, error));
  } else if (const auto id = id_of(path)) {
    current()->own[*id] = fs::absolute(path);
  }
}

bool check_target(const fs::path& path) {
  const std::lock_guard lock(guard_mutex);
  if (!current() || path == "-" || !is_file(path)) return false;
  const std::optional<FileId> id = id_of(path);
  if (!id) return false;
  const bool own = is_own(path, *id);
  if (!holds_file(current()->own, *id) && holds_file(current()->inputs, *id))
    fail(ErrorKind::usage, "{}: is an input of this command, which never writes onto its inputs",
         path.string());
  if (own) return false;
  if (current()->overwrite || is_own_report(path)) return true;
  fail(ErrorKind::usage, "{}: exists already: choose another name, or replace it with {}",
       path.string(), current()->option);
}

void note_written(const fs::path& path, bool replaced) {
  const std::lock_guard lock(guard_mutex);
  if (!current()) return;
  if (const auto id = id_of(path)) current()->own[*id] = fs::absolute(path);
  current()->replaced += replaced ? 1 : 0;
  current()->written.count += 1;
  current()->written.last = path;
}

void require_new_folder(const fs::path& folder, bool overwrite) {
  std::error_code error;
  if (overwrite || !fs::is_directory(folder, error) || fs::is_empty(folder, error)) return;
  fail(ErrorKind::usage,
       "{}: this folder exists already and is not empty: choose another name, or replace its files "
       "with --overwrite",
       folder.string());
}

fs::path own_name(const fs::path& path) {
  std::error_code error;
  fs::path name = path;
  for (int n = 1; fs::exists(fs::symlink_status(name, error)) && !is_own_report(name); ++n)
    name = path.parent_path() /
           fmt::format("{}_{:04}{}", path.stem().string(), n, path.extension().string());
  return name;
}

bool is_own_report(const fs::path& path) {
  std::string ending = lower_case(path.extension().string());
  if (ending == ".jpeg") ending = ".jpg";
  if (ending == ".tiff") ending = ".tif";
  if (holds(path, ending)) return true;
  // gnuplot draws NAME.png and NAME.svg by NAME.gp.
  if (ending != ".png" && ending != ".svg") return false;
  return holds(fs::path(path).replace_extension(".gp"), ".gp");
}

}  // namespace qs
