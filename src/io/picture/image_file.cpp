// SPDX-License-Identifier: MIT
//
// Loads the OpenImageIO module on first use and keeps it until the process ends. It is searched
// beside the executable (build tree) and in ../lib/quadsplat (installation).
#include "io/picture/image_file.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <dlfcn.h>

#include "base/assets.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/lfs_pointer.h"
#include "io/bytes/replace_file.h"
#include "io/picture/oiio/module.h"
#include "io/picture/panorama_tag.h"
#include "io/picture/picture_formats.h"

namespace qs {
namespace {

constexpr std::array kFormats = {
    PictureFormat{".png", read_png, write_png}, PictureFormat{".jpg", read_jpeg, write_with_module},
    PictureFormat{".ppm", read_ppm, write_ppm}, PictureFormat{".pfm", read_pfm, write_pfm},
    PictureFormat{".npy", read_npy, write_npy},
};

// The fallback for all other extensions.
constexpr PictureFormat kModule{"", read_with_module, write_with_module};

const PictureFormat& format_with(std::string_view extension) {
  const auto found = std::ranges::find(kFormats, extension, &PictureFormat::extension);
  return found == kFormats.end() ? kModule : *found;
}

const PictureFormat& format_of(const std::filesystem::path& path) {
  return format_with(picture_extension(path));
}

// The format by the first bytes; without known ones by the ending, which is wrong for many files.
const PictureFormat& format_in(const std::filesystem::path& path) {
  std::array<char, 64> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  const std::string_view bytes(start.data(), start.size());
  refuse_lfs_pointer(bytes, path);
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return format_with(".png");
  return bytes.starts_with("\xff\xd8\xff") ? format_with(".jpg") : format_of(path);
}

void write_by(WritePicture* write, const Image& image, const std::filesystem::path& path,
              const ImageMetadata& metadata, const Progress& progress) {
  assert(image.width > 0 && image.height > 0 && image.channels >= 1 && image.channels <= 4);
  replace_file(path, [&](const std::filesystem::path& temporary) {
    write(image, {temporary, path, progress}, with_software(metadata));
  });
}

const OiioModule& load(const std::filesystem::path& picture) {
  const std::filesystem::path folder = program_folder();
  const std::string wanted =
      fmt::format("{}: pictures of this format need the OpenImageIO module", picture.string());
  for (const auto& file :
       {folder / kOiioModuleFile, folder / "../lib/quadsplat" / kOiioModuleFile}) {
    if (!is_there(file)) continue;
    void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      const char* reason = dlerror();
      fail(ErrorKind::device, "{}, which cannot be loaded: {}", wanted,
           reason ? reason : "unknown reason");
    }
    const auto entry =
        reinterpret_cast<decltype(&quadsplat_oiio_module)>(dlsym(library, kOiioModuleEntry));
    if (!entry || entry()->version != kOiioModuleVersion)
      fail(ErrorKind::device, "{}, but {} belongs to another version of quadsplat", wanted,
           file.string());
    return *entry();
  }
  fail(ErrorKind::device,
       "{} ({}), which is not installed; .png, .ppm, .pfm and .npy work without it, and "
       "reading .jpg",
       wanted, kOiioModuleFile);
}

const OiioModule& module_for(const std::filesystem::path& picture) {
  static const OiioModule& module = load(picture);
  return module;
}

}  // namespace

Image read_with_module(const std::filesystem::path& path) {
  const OiioModule& module = module_for(path);
  OiioMessage message{};
  OiioPicture picture{};
  const std::unique_ptr<void, void (*)(void*)> input(module.open(path.c_str(), &picture, &message),
                                                     module.close);
  if (!input) fail("{}: not a readable picture: {}", path.string(), message.text);
  check_picture_size(path, picture.width, picture.height, picture.channels);
  Image image(picture.width, picture.height, picture.channels);
  picture.values = image.values.data();
  if (!module.read(input.get(), &picture, &message))
    fail("{}: damaged picture: {}", path.string(), message.text);
  return image;
}

void write_with_module(const Image& image, const PictureTarget& target,
                       const ImageMetadata& metadata) {
  const OiioModule& module = module_for(target.shown);
  std::vector<OiioText> texts;
  for (const auto& [key, value] : metadata)
    if (key != kChannelText && key != kXmpText) texts.push_back({key.c_str(), value.c_str()});
  const auto channel = metadata.find(kChannelText);
  const bool named = channel != metadata.end() && image.channels == 1;
  // The module does not write through `values`.
  const OiioPicture picture{image.width, image.height, image.channels,
                            const_cast<float*>(image.values.data()),
                            named ? channel->second.c_str() : nullptr};
  OiioMessage message{};
  if (!module.write(target.file.c_str(), &picture, texts.data(), static_cast<int>(texts.size()),
                    &message))
    fail("{}: cannot be written: {}", target.shown.string(), message.text);
  const auto xmp = metadata.find(kXmpText);
  if (xmp != metadata.end() && picture_extension(target.shown) == ".jpg")
    add_xmp(target.file, target.shown, xmp->second);
}

std::span<const PictureFormat> picture_formats() { return kFormats; }

std::string picture_extension(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".jpeg" ? ".jpg" : extension;
}

ImageMetadata with_software(ImageMetadata metadata) {
  metadata.emplace("Software", "quadsplat");
  return metadata;
}

std::string read_picture_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("{}: cannot be opened", path.string());
  std::ostringstream content;
  content << file.rdbuf();  // in blocks, also from pipes
  return std::move(content).str();
}

std::ofstream open_picture(const PictureTarget& target) {
  std::ofstream file(target.file, std::ios::binary);
  if (!file) fail("{}: cannot be written: the folder does not allow it", target.shown.string());
  errno = 0;
  return file;
}

void close_picture(std::ofstream& file, const PictureTarget& target) {
  file.close();
  if (!file) fail_to_write(target.shown, target.file);
}

void check_picture_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height,
                        std::int64_t channels) {
  constexpr std::int64_t kMaxSide = 65535;
  constexpr std::int64_t kMaxValues = std::int64_t{1} << 29;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    fail("{}: a picture of {} x {} pixels is not between 1 x 1 and {} x {}", path.string(), width,
         height, kMaxSide, kMaxSide);
  if (channels < 1 || channels > 4)
    fail("{}: {} channels, but 1 to 4 are supported", path.string(), channels);
  if (width * height * channels > kMaxValues)
    fail("{}: a picture of {} x {} pixels is too large", path.string(), width, height);
}

Image read_image(const std::filesystem::path& path) {
  if (!is_there(path)) fail("{}: no such file", path.string());
  if (!is_file(path)) fail("{}: not a file", path.string());
  note_input(path);
  return format_in(path).read(path);
}

void check_picture_name(const std::filesystem::path& path) {
  if (path.extension().empty())
    fail(ErrorKind::usage, "{}: the name needs an ending such as .png that tells the format",
         path.string());
}

void write_image(const Image& image, const std::filesystem::path& path,
                 const ImageMetadata& metadata, const Progress& progress) {
  check_picture_name(path);
  write_by(format_of(path).write, image, path, metadata, progress);
}

void write_16_bit_png(const Image& image, const std::filesystem::path& path,
                      const ImageMetadata& metadata, const Progress& progress) {
  write_by(write_png_16, image, path, metadata, progress);
}

}  // namespace qs
