// SPDX-License-Identifier: MIT
//
// Loads the OpenImageIO module on first use and keeps it until the process ends. It is searched
// beside the executable (build tree) and in ../lib/quadsplat (installation).
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <dlfcn.h>

#include "base/assets.h"
#include "base/fail.h"
#include "io/picture/oiio/module.h"
#include "io/picture/picture_formats.h"

namespace qs {
namespace {

const OiioModule& load(const std::filesystem::path& picture) {
  const std::filesystem::path folder = program_folder();
  const std::string wanted =
      fmt::format("{}: pictures of this format need the OpenImageIO module", picture.string());
  for (const auto& file :
       {folder / kOiioModuleFile, folder / "../lib/quadsplat" / kOiioModuleFile}) {
    std::error_code error;
    if (!std::filesystem::exists(file, error)) continue;
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
    if (key != kChannelText) texts.push_back({key.c_str(), value.c_str()});
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
}

}  // namespace qs
