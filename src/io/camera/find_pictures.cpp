// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <compare>
#include <span>
#include <system_error>
#include <utility>

#include "base/fail.h"
#include "base/list_of.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/camera/camera_formats.h"
#include "io/camera/photographs.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

// A path as words.
struct PicturePlace {
  std::vector<std::string> folders;
  std::string file;

  explicit PicturePlace(const std::string& path) : folders(separated(path, '/')) {
    file = std::move(folders.back());
    folders.pop_back();
    std::erase_if(folders, [](const std::string& word) { return word.empty() || word == "."; });
  }

  std::string key() const { return lower_case(photograph_name(file)); }
  std::string ending() const { return lower_case(file.substr(photograph_name(file).size())); }
};

// The agreement of a name and a picture; a larger one is better.
struct Agreement {
  bool whole = false;       // the picture is at the end of the name's path
  std::size_t folders = 0;  // equal folders before the file
  bool ending = false, letter_case = false;

  auto operator<=>(const Agreement&) const = default;
};

Agreement agreement_of(const PicturePlace& name, const PicturePlace& picture) {
  const auto begin = name.folders.rbegin(), other_begin = picture.folders.rbegin();
  const auto [end, other_end] = std::mismatch(
      begin, name.folders.rend(), other_begin, picture.folders.rend(),
      [](const std::string& a, const std::string& b) { return lower_case(a) == lower_case(b); });
  return {.whole = other_end == picture.folders.rend(),
          .folders = static_cast<std::size_t>(end - begin),
          .ending = name.ending() == picture.ending(),
          .letter_case = photograph_name(name.file) == photograph_name(picture.file) &&
                         std::equal(begin, end, other_begin)};
}

fs::path identity(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::weakly_canonical(path, error);
  return error ? path : real;
}

std::string with_slashes(std::string name) {
  std::ranges::replace(name, '\\', '/');
  return name;
}

// True for a folder of pictures that are no photographs.
bool has_other_pictures(const fs::path& folder) {
  constexpr std::array kNames = {"mask",   "masks",   "depth",         "depths",      "depth_maps",
                                 "normal", "normals", "dynamic_masks", "segmentation"};
  const std::string name = lower_case(folder.filename().string());
  return std::ranges::find(kNames, name) != kNames.end();
}

}  // namespace

Photographs::Photographs(const fs::path& folder,
                         const std::function<void(std::size_t count)>& counted)
    : folder_(folder) {
  if (!is_folder(folder)) fail("{}: not a folder of pictures", folder.string());
  // Links are followed after all folders, so that a folder is listed under its own name.
  std::set<std::pair<bool, fs::path>> open = {{false, folder}};
  std::set<fs::path> listed;
  while (!open.empty()) {
    const fs::path place = open.extract(open.begin()).value().second;
    if (!listed.insert(identity(place)).second) continue;
    std::error_code error;
    for (auto entry =
             fs::directory_iterator(place, fs::directory_options::skip_permission_denied, error);
         !error && entry != fs::directory_iterator(); entry.increment(error)) {
      std::error_code unreachable;  // for example a broken link
      if (entry->path().filename().string().starts_with('.')) continue;
      if (entry->is_directory(unreachable)) {
        if (has_other_pictures(entry->path())) continue;
        folders_.insert(lower_case(entry->path().filename().string()));
        open.emplace(entry->is_symlink(unreachable), entry->path());
      } else if (entry->is_regular_file(unreachable)) {
        const std::string file = entry->path().lexically_relative(folder).generic_string();
        if (photograph_name(file) == file) continue;  // not the ending of a picture
        files_.insert(file);
        by_name_.emplace(PicturePlace(file).key(), file);
        if (counted) counted(files_.size());
      }
    }
    if (error) fail("{}: cannot be listed: {}", place.string(), error.message());
  }
}

std::optional<Photographs::Match> Photographs::match(const std::string& name) const {
  const PicturePlace wanted(name);
  Agreement best;
  std::vector<std::string> found;
  const auto [begin, end] = by_name_.equal_range(wanted.key());
  for (auto row = begin; row != end; ++row) {
    const std::string& file = row->second;
    const PicturePlace picture(file);
    const Agreement agreement = agreement_of(wanted, picture);
    // If the name's folder exists, its picture is missing there, and another folder's is another.
    if (!agreement.whole && agreement.folders < wanted.folders.size() &&
        folders_.contains(lower_case(
            *(wanted.folders.rbegin() + static_cast<std::ptrdiff_t>(agreement.folders)))))
      continue;
    if (found.empty() || agreement > best) {
      best = agreement;
      found = {file};
    } else if (agreement == best) {
      found.push_back(file);
    }
  }
  std::ranges::sort(found);
  if (found.size() > 1)
    fail(
        "{}: two pictures are named like {}: {} and {}; name one of them with its folder and "
        "ending",
        folder_.string(), name, (folder_ / found[0]).string(), (folder_ / found[1]).string());
  if (!found.empty()) return Match{folder_ / found[0], !best.whole};
  const std::string spelled = with_slashes(name);
  return spelled == name ? std::nullopt : match(spelled);
}

std::optional<fs::path> Photographs::find(const std::string& name) const {
  const auto found = match(name);
  return found ? std::optional(found->file) : std::nullopt;
}

std::vector<std::string> Photographs::names() const {
  return list_of<std::string>(files_, photograph_name);
}

std::vector<fs::path> Photographs::files() const {
  return list_of<fs::path>(files_, [&](const std::string& file) { return folder_ / file; });
}

fs::path path_of(const std::string& name) {
  return fs::path(with_slashes(name)).lexically_normal();
}

std::optional<fs::path> shared_folder(const std::vector<std::string>& names, const fs::path& from) {
  std::optional<fs::path> shared;
  for (const std::string& name : names) {
    const fs::path path = path_of(name);
    if (path.is_absolute()) return std::nullopt;
    fs::path first;
    for (const fs::path& word : path.parent_path()) {
      first /= word;
      if (word != "..") break;
    }
    if (first.empty() || (shared && *shared != first)) return std::nullopt;
    shared = first;
  }
  if (!shared || !is_folder(from / *shared)) return std::nullopt;
  return from / *shared;
}

std::optional<fs::path> file_at(const fs::path& from, const std::string& name) {
  for (const std::string& spelled : {name, with_slashes(name)})
    if (!name.empty() && is_file(from / spelled)) return (from / spelled).lexically_normal();
  return std::nullopt;
}

fs::path path_in(const fs::path& file, const fs::path& folder) {
  return fs::absolute(file).lexically_normal().lexically_relative(
      fs::absolute(folder).lexically_normal());
}

std::optional<fs::path> picture_at(const fs::path& from, const std::string& name) {
  if (auto file = file_at(from, name)) return file;
  const fs::path folder = (from / with_slashes(name)).parent_path();
  const auto found = Photographs(is_folder(folder) ? folder : from).match(name);
  return found && !found->by_name_alone ? std::optional(found->file) : std::nullopt;
}

std::vector<fs::path> find_pictures(const std::vector<std::string>& names, const fs::path& from,
                                    const Photographs& pictures, bool may_share) {
  std::vector<fs::path> found(names.size());
  std::map<fs::path, std::size_t> owners;  // of pictures, by identity()
  const auto take = [&](std::size_t i, const fs::path& file) {
    const auto [owner, added] = owners.try_emplace(identity(file), i);
    const std::string& other = names[owner->second];
    if (!added && !may_share)
      fail("{}: one picture for two cameras, {}", file.string(),
           other == names[i] ? "both named " + other : other + " and " + names[i]);
    found[i] = file;
  };
  std::vector<std::optional<Photographs::Match>> matches(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto file = from.empty() ? std::nullopt : file_at(from, names[i]);
    if (!file) matches[i] = pictures.match(names[i]);
    if (file) take(i, *file);
  }
  // Pictures whose folders agree first: the others are only for names that have no such picture.
  for (const bool by_name_alone : {false, true})
    for (std::size_t i = 0; i < names.size(); ++i)
      if (matches[i] && matches[i]->by_name_alone == by_name_alone &&
          (!by_name_alone || !owners.contains(identity(matches[i]->file))))
        take(i, matches[i]->file);
  return found;
}

std::vector<std::string> photograph_names(const std::vector<LensCamera>& cameras) {
  return list_of<std::string>(cameras, [](const LensCamera& camera) {
    return camera.photograph.empty() ? camera.camera.name : camera.photograph;
  });
}

}  // namespace qs
