// SPDX-License-Identifier: MIT
//
// quadsplat.h for C++17: handles that close themselves, and exceptions. Everything is inline. The
// structs, settings and rules are those of quadsplat.h.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "quadsplat/quadsplat.h"

namespace quadsplat {

/// The result of a function that is not QS_OK, with its sentence.
class Error : public std::runtime_error {
 public:
  Error(std::int32_t code, const std::string& sentence)
      : std::runtime_error(sentence), code_(code) {}
  std::int32_t code() const { return code_; }  ///< QS_USAGE, QS_INPUT, ...

 private:
  std::int32_t code_;
};

/// Calls a function of quadsplat.h, with a message as the last argument. Throws Error.
template <class... Parameters, class... Arguments>
void check(std::int32_t (*function)(Parameters...), Arguments&&... arguments) {
  char message[QS_MESSAGE_BYTES];
  const std::int32_t code = function(std::forward<Arguments>(arguments)..., message);
  if (code != QS_OK) throw Error(code, message);
}

/// A struct of quadsplat.h with its size, and 0 in all other members.
template <class Struct>
Struct sized() {
  Struct made{};
  made.size = sizeof(Struct);
  return made;
}

inline QsSettings default_settings() { return QS_SETTINGS; }
inline QsConversion default_conversion() { return QS_CONVERSION; }
inline QsRules default_rules() { return QS_RULES; }
inline QsAdam default_adam() { return QS_ADAM; }

/// QS_FLOAT32, ... of an element.
template <class T>
constexpr std::uint32_t type_of() {
  using Element = std::remove_const_t<T>;
  if (std::is_same_v<Element, float>) return QS_FLOAT32;
  if (std::is_same_v<Element, double>) return QS_FLOAT64;
  if (std::is_same_v<Element, std::uint8_t>) return QS_UINT8;
  if (std::is_same_v<Element, std::int32_t>) return QS_INT32;
  if (std::is_same_v<Element, std::uint32_t>) return QS_UINT32;
  if (std::is_same_v<Element, std::int64_t>) return QS_INT64;
  static_assert(std::is_arithmetic_v<Element>, "quadsplat: no type of elements");
  return QS_UINT64;
}

/// An array in host memory of up to 4 dimensions, row by row without padding.
template <class T>
QsArray array_of(T* data, std::initializer_list<std::int64_t> sizes) {
  QsArray array{};
  array.data = const_cast<std::remove_const_t<T>*>(data);
  for (const std::int64_t size : sizes) array.sizes[array.dimensions++] = size;
  std::int64_t stride = 1;
  for (std::uint32_t i = array.dimensions; i-- > 0; stride *= array.sizes[i])
    array.strides[i] = stride;
  array.type = type_of<T>();
  return array;
}

/// A picture of height x width x 3 values that is stored in planes, channel by channel.
template <class T>
QsArray planes_of(T* data, std::int64_t height, std::int64_t width) {
  QsArray array = array_of(data, {height, width, 3});
  array.strides[0] = width;
  array.strides[1] = 1;
  array.strides[2] = width * height;
  return array;
}

namespace detail {
struct Close {
  void operator()(QsContext* context) const { qs_context_close(context); }
  void operator()(QsSceneHandle* scene) const { qs_scene_close(scene); }
  void operator()(QsCameras* cameras) const { qs_cameras_close(cameras); }
};
}  // namespace detail

/// The cameras of a file: `with_lenses` by qs_cameras_lens(), else by qs_cameras_get().
inline std::vector<QsCamera> read_cameras(const std::string& path,
                                          std::vector<std::string>* names = nullptr,
                                          bool with_lenses = false) {
  QsCameras* opened = nullptr;
  std::uint64_t count = 0;
  check(qs_cameras_open, path.c_str(), &opened, &count);
  const std::unique_ptr<QsCameras, detail::Close> cameras(opened);
  std::vector<QsCamera> list(count, sized<QsCamera>());
  if (names != nullptr) names->clear();
  for (std::uint64_t i = 0; i < count; ++i) {
    const char* name = nullptr;
    check(with_lenses ? qs_cameras_lens : qs_cameras_get, opened, i, &list[i], &name);
    if (names != nullptr) names->emplace_back(name);
  }
  return list;
}

class Scene {
 public:
  /// Takes over a handle.
  explicit Scene(QsSceneHandle* handle) : handle_(handle) {}

  QsSceneHandle* get() const { return handle_.get(); }

  QsSceneFacts facts() const {
    auto facts = sized<QsSceneFacts>();
    check(qs_scene_facts, get(), &facts);
    return facts;
  }
  /// Copies the Gaussians into the arrays, see qs_scene_gaussians().
  void gaussians(const QsGaussians& arrays) { check(qs_scene_gaussians, get(), &arrays); }
  void render(const QsCamera& camera, const QsPicture& picture,
              const QsSettings& settings = default_settings()) {
    check(qs_render, get(), &camera, std::uint64_t{1}, &settings, &picture);
  }
  /// Both lists have the same length.
  void render(const std::vector<QsCamera>& cameras, const std::vector<QsPicture>& pictures,
              const QsSettings& settings = default_settings()) {
    if (cameras.size() != pictures.size())
      throw Error(QS_USAGE, "render: there are not as many pictures as cameras");
    check(qs_render, get(), cameras.data(), std::uint64_t{cameras.size()}, &settings,
          pictures.data());
  }
  QsLists lists(const QsCamera& camera, const QsSettings& settings = default_settings()) {
    auto lists = sized<QsLists>();
    check(qs_lists, get(), &camera, &settings, &lists);
    return lists;
  }
  std::vector<QsModeCounts> count_modes(const QsCamera& camera,
                                        const QsSettings& settings = default_settings()) {
    std::uint64_t count = 0;
    check(qs_count_modes, get(), &camera, &settings, nullptr, std::uint64_t{0}, &count);
    std::vector<QsModeCounts> counts(count, sized<QsModeCounts>());
    check(qs_count_modes, get(), &camera, &settings, counts.data(), count, &count);
    return counts;
  }
  /// The selected Gaussians after edits, 0 or 1 for each; `left`, if given, those that are left. See
  /// qs_select().
  std::vector<std::uint8_t> select(const std::string& edits,
                                   std::vector<std::uint8_t>* left = nullptr) {
    const std::uint64_t count = facts().gaussians;
    std::vector<std::uint8_t> selected(count), rest(left != nullptr ? count : 0);
    const auto size = static_cast<std::int64_t>(count);
    const QsArray of_selected = array_of(selected.data(), {size});
    const QsArray of_rest = array_of(rest.data(), {size});
    check(qs_select, get(), edits.c_str(), &of_selected, left != nullptr ? &of_rest : nullptr);
    if (left != nullptr) *left = std::move(rest);
    return selected;
  }
  /// The points under pixels x, y, x, y, ...; see qs_measure().
  std::vector<QsSurfacePoint> measure(const QsCamera& camera,
                                      const std::vector<std::int32_t>& pixels,
                                      const QsSettings& settings = default_settings()) {
    std::vector<QsSurfacePoint> points(pixels.size() / 2);
    check(qs_measure, get(), &camera, &settings, pixels.data(), std::uint64_t{points.size()},
          points.data());
    return points;
  }
  void convert(const std::string& path, const QsConversion& conversion = default_conversion()) {
    check(qs_convert, get(), path.c_str(), &conversion);
  }

 private:
  std::unique_ptr<QsSceneHandle, detail::Close> handle_;
};

class Context {
 public:
  /// See qs_context_open().
  explicit Context(std::uint32_t backend = QS_BACKEND_AUTO, std::int32_t device = QS_FIRST_GPU,
                   std::int32_t threads = 0) {
    QsContext* opened = nullptr;
    check(qs_context_open, backend, device, threads, &opened);
    handle_.reset(opened);
  }

  QsContext* get() const { return handle_.get(); }
  std::uint32_t backend() const { return qs_context_backend(get()); }

  Scene load(const std::string& path, const std::string& axes = {}) {
    QsSceneHandle* scene = nullptr;
    check(qs_scene_load, get(), path.c_str(), axes.c_str(), &scene);
    return Scene(scene);
  }
  Scene wrap(const QsGaussians& gaussians) {
    QsSceneHandle* scene = nullptr;
    check(qs_scene_wrap, get(), &gaussians, &scene);
    return Scene(scene);
  }
  /// `asked` names the metrics; the result holds them.
  QsComparison compare(const QsArray& a, const QsArray& b, QsComparison asked) {
    check(qs_compare, get(), &a, &b, &asked);
    return asked;
  }
  /// The mean SSIM of batches of pictures.
  double ssim(const QsArray& a, const QsArray& b, std::uint32_t border = QS_BORDER_ZEROS) {
    double mean = 0;
    check(qs_ssim, get(), &a, &b, border, &mean);
    return mean;
  }
  void step(const QsAdam& adam) { check(qs_adam, get(), &adam); }
  /// Any thread may call it.
  void stop() { qs_stop(get()); }

 private:
  std::unique_ptr<QsContext, detail::Close> handle_;
};

}  // namespace quadsplat
