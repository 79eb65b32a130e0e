// SPDX-License-Identifier: MIT
#include "app/viewer/window/presenter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "app/picture/palette.h"
#include "app/viewer/state/actions.h"
#include "base/assets.h"
#include "base/error.h"
#include "base/fail.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

constexpr int kColors = 256;

unsigned compiled(GLenum kind, const char* name) {
  const auto path = find_asset(std::string("shaders/") + name);
  if (!path) fail(ErrorKind::device, "view: the program's file shaders/{} is missing", name);
  std::ifstream file(*path);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const char* source = text.c_str();
  const unsigned shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  int good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good == 0) {
    std::array<char, 1000> log{};
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    fail(ErrorKind::device, "view: {} does not compile: {}", path->string(), log.data());
  }
  return shader;
}

// The program of a fragment shader that covers the window.
unsigned linked(const char* fragment_name) {
  const unsigned vertex = compiled(GL_VERTEX_SHADER, "present.vert");
  const unsigned fragment = compiled(GL_FRAGMENT_SHADER, fragment_name);
  const unsigned program = glCreateProgram();
  glAttachShader(program, vertex);
  glAttachShader(program, fragment);
  glLinkProgram(program);
  int good = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &good);
  if (good == 0) fail(ErrorKind::device, "view: the shaders do not link");
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  return program;
}

unsigned new_texture(GLenum target, GLint filter) {
  unsigned texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(target, texture);
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

// Fills a texture with `color(t)` for t from 0 to 1.
template <class Color>
void fill_with_colors(unsigned texture, const Color& color) {
  glBindTexture(GL_TEXTURE_1D, texture);
  std::array<glm::vec3, kColors> colors;
  for (int i = 0; i < kColors; ++i)
    colors[static_cast<std::size_t>(i)] = color(static_cast<float>(i) / (kColors - 1));
  glTexImage1D(GL_TEXTURE_1D, 0, GL_RGB8, kColors, 0, GL_RGB, GL_FLOAT, colors.data());
}

// Uploads the values of a map, if there is one.
void upload_map(unsigned texture, const std::optional<HeatLayer>& layer) {
  if (!layer) return;
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, layer->columns, layer->rows, 0, GL_RED, GL_FLOAT,
               layer->values.data());
}

// A picture below a map is also sampled at a lower resolution, for the contrast of the map.
void add_mipmaps(unsigned texture, bool below_map) {
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                  below_map ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR);
  if (below_map) glGenerateMipmap(GL_TEXTURE_2D);
}

void bind(int unit, GLenum target, unsigned texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(unit));
  glBindTexture(target, texture);
}

}  // namespace

HeatLayers layers_of(const ShownFrame& shown) {
  const auto layer = [&](const std::optional<Heatmap>& map) -> std::optional<HeatLayer> {
    if (!map) return std::nullopt;
    return HeatLayer{.columns = map->columns,
                     .rows = map->rows,
                     .cell_px = map->cell_px,
                     .values = {map->values.begin(), map->values.end()},
                     .high = static_cast<float>(shown.map_scale.maximum)};
  };
  if (shown.grid) return {};  // its pictures contain their maps
  HeatLayers layers{layer(shown.heatmap), std::nullopt, std::nullopt};
  if (!shown.other) return layers;
  layers.other = layer(shown.other->heatmap);
  if (shown.other->pairs) {
    const auto& [grid, differences, total] = *shown.other->pairs;
    const auto high = static_cast<float>(shown.other->pairs_scale.maximum);
    layers.difference =
        HeatLayer{grid.columns, grid.rows, grid.tile_px, {differences.begin(), differences.end()},
                  -high,        high};
  }
  return layers;
}

PixelBox fitted(const PixelBox& area, double aspect) {
  const int width = area.x1 - area.x0, height = area.y1 - area.y0;
  // A frame's size is rounded to pixels, so a difference of a pixel is no other aspect.
  const int fit_width = static_cast<int>(std::lround(height * aspect));
  const int fit_height = static_cast<int>(std::lround(width / aspect));
  if (std::abs(fit_width - width) <= 1 || std::abs(fit_height - height) <= 1) return area;
  if (fit_width < width) {
    const int x0 = area.x0 + (width - fit_width) / 2;
    return {x0, area.y0, x0 + std::max(fit_width, 1), area.y1};
  }
  const int y0 = area.y0 + (height - fit_height) / 2;
  return {area.x0, y0, area.x1, y0 + std::max(fit_height, 1)};
}

Enlarging suitable_enlarging() {
  const std::string_view renderer(reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
  for (const char* software : {"llvmpipe", "softpipe", "SwiftShader", "Software Rasterizer"})
    if (renderer.find(software) != std::string_view::npos) return Enlarging::linear;
  return Enlarging::cubic;
}

Presenter::Presenter(Enlarging enlarging) : enlarging_(enlarging) {
  frame_program_ = linked("frame.frag");
  glUseProgram(frame_program_);
  glUniform1i(glGetUniformLocation(frame_program_, "picture"), 0);
  program_ = linked("present.frag");
  glUseProgram(program_);
  int unit = 0;
  for (const char* texture : {"picture", "other", "heat", "colors", "other_heat"})
    glUniform1i(uniform(texture), unit++);
  glGenVertexArrays(1, &empty_vertices_);
  glGenQueries(1, &query_);
  glGenBuffers(1, &pixels_);
  for (unsigned* picture : {&picture_, &other_}) *picture = new_texture(GL_TEXTURE_2D, GL_LINEAR);
  for (unsigned* map : {&heat_, &other_heat_, &difference_})
    *map = new_texture(GL_TEXTURE_2D, GL_NEAREST);
  for (unsigned* colors : {&rising_colors_, &signed_colors_})
    *colors = new_texture(GL_TEXTURE_1D, GL_LINEAR);
  fill_with_colors(rising_colors_, [](float t) { return heat(t); });
  fill_with_colors(signed_colors_, [](float t) { return diverging(2 * t - 1); });
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
}

Presenter::~Presenter() {
  for (const unsigned* texture :
       {&picture_, &other_, &heat_, &other_heat_, &difference_, &rising_colors_, &signed_colors_})
    glDeleteTextures(1, texture);
  glDeleteQueries(1, &query_);
  glDeleteBuffers(1, &pixels_);
  glDeleteVertexArrays(1, &empty_vertices_);
  glDeleteProgram(program_);
  glDeleteProgram(frame_program_);
}

void Presenter::show(RenderedFrame frame, GlFrames* frames) {
  if (frame.texture.name != 0) {
    // OpenGL may still draw from the newest texture, so it is kept for one more frame.
    frames->give_back(previous_);
    previous_ = std::exchange(newest_, frame.texture);
  }
  layers_ = layers_of(frame.shown);
  next_ = std::move(frame);
}

void Presenter::clear() {
  next_.reset();
  layers_ = {};
  width_ = height_ = 0;
}

void Presenter::upload_pixels(unsigned texture, const std::vector<std::uint8_t>& rgba) const {
  glBindTexture(GL_TEXTURE_2D, texture);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, pixels_);
  glBufferData(GL_PIXEL_UNPACK_BUFFER, static_cast<GLsizeiptr>(rgba.size()), rgba.data(),
               GL_STREAM_DRAW);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width_, height_, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

void Presenter::upload() {
  const RenderedFrame frame = *std::exchange(next_, std::nullopt);
  shown_ = frame.texture.name != 0 ? frame.texture.name : picture_;
  width_ = frame.width;
  height_ = frame.height;
  const Camera& camera = frame.shown.camera;
  aspect_ = camera.width > 0 && camera.height > 0
                ? static_cast<double>(camera.width) / camera.height
                : static_cast<double>(width_) / std::max(height_, 1);
  has_other_ = !frame.other.empty();
  glActiveTexture(GL_TEXTURE0);
  if (shown_ == picture_) upload_pixels(picture_, frame.rgba);
  if (has_other_) upload_pixels(other_, frame.other);
  upload_map(heat_, layers_.picture);
  upload_map(other_heat_, layers_.other);
  upload_map(difference_, layers_.difference);
  if (has_other_) add_mipmaps(other_, has_layers());
  add_mipmaps(shown_, has_layers());
}

void Presenter::draw(glm::ivec2 window, const PixelBox& area, const Split& split,
                     const HeatStyle& style) {
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glClearColor(0.075f, 0.08f, 0.095f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  if (next_) {
    begin_timing();
    upload();
  }
  if (width_ == 0) return;
  const PixelBox place = fitted(area, aspect_);
  glViewport(place.x0, window.y - place.y1, place.x1 - place.x0, place.y1 - place.y0);
  const bool enlarged = width_ < place.x1 - place.x0 || height_ < place.y1 - place.y0;
  const bool cubic = enlarged && enlarging_ == Enlarging::cubic;
  if (cubic || has_other_ || has_layers()) {
    set_up_layers(cubic, split, style);
  } else {
    glUseProgram(frame_program_);
  }
  bind(0, GL_TEXTURE_2D, shown_);
  glBindVertexArray(empty_vertices_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
  end_timing();
}

int Presenter::uniform(const char* name) const { return glGetUniformLocation(program_, name); }

// Sets the uniforms of present.frag.
void Presenter::set_up_layers(bool cubic, const Split& split, const HeatStyle& style) {
  glUseProgram(program_);
  glUniform1i(uniform("cubic"), cubic ? 1 : 0);
  glUniform1i(uniform("split"), has_other_ ? 1 + static_cast<int>(split.view) : 0);
  glUniform1i(uniform("flipped"), split.flipped ? 1 : 0);
  glUniform1f(uniform("divider"), split.divider);
  glUniform1f(uniform("amplification"), static_cast<float>(split.amplification));
  set_up_heat(split, style);
  bind(1, GL_TEXTURE_2D, other_);
}

// The maps that the split shows: the difference of the pairs alone, or the map of each side.
void Presenter::set_up_heat(const Split& split, const HeatStyle& style) {
  const bool differs = has_other_ && split.view == SplitView::tile_pairs;
  const bool hidden = has_other_ && split.view == SplitView::difference;
  const std::optional<HeatLayer>& layer = differs ? layers_.difference : layers_.picture;
  const bool shown = layer && !hidden;
  glUniform1f(uniform("heat_low"), shown ? layer->low : 0);
  glUniform1f(uniform("heat_high"), shown ? layer->high : 0);
  glUniform1f(uniform("opacity"), differs ? 1 : style.opacity);
  const glm::vec2 cells =
      glm::vec2(width_, height_) / static_cast<float>(layer ? layer->cell_px : 1);
  glUniform2f(uniform("heat_cells"), cells.x, cells.y);
  if (std::exchange(colors_, style.colors) != style.colors)
    fill_with_colors(rising_colors_, [&](float t) { return heat(t, style.colors); });
  bind(4, GL_TEXTURE_2D, layers_.other ? other_heat_ : heat_);
  bind(3, GL_TEXTURE_1D, differs ? signed_colors_ : rising_colors_);
  bind(2, GL_TEXTURE_2D, differs ? difference_ : heat_);
}

// One query at a time: the next query begins after the result of the last query was read.
void Presenter::begin_timing() {
  if (timed_) {
    int ready = 0;
    glGetQueryObjectiv(query_, GL_QUERY_RESULT_AVAILABLE, &ready);
    if (ready == 0) return;
    GLuint64 nanoseconds = 0;
    glGetQueryObjectui64v(query_, GL_QUERY_RESULT, &nanoseconds);
    gpu_ms_ = static_cast<float>(static_cast<double>(nanoseconds) * 1e-6);
    timed_ = false;
  }
  if (timing_) return;
  glBeginQuery(GL_TIME_ELAPSED, query_);
  timing_ = true;
}

void Presenter::end_timing() {
  if (!timing_) return;
  glEndQuery(GL_TIME_ELAPSED);
  timing_ = false;
  timed_ = true;
}

void Presenter::finish() { glFinish(); }

Image Presenter::grab(int width, int height) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint8_t> rgb(3 * pixels);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
  Image image(width, height, 3);
  const auto stride = 3 * static_cast<std::size_t>(width);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* from = rgb.data() + static_cast<std::size_t>(height - 1 - y) * stride;
    for (std::size_t i = 0; i < stride; ++i) image.row(y)[i] = static_cast<float>(from[i]) / 255.0f;
  }
  return image;
}

PictureTexture::~PictureTexture() {
  if (texture_ != 0) glDeleteTextures(1, &texture_);
}

unsigned PictureTexture::show(const std::shared_ptr<const Image>& image) {
  if (image == nullptr || image == image_) return image == nullptr ? 0 : texture_;
  image_ = image;
  std::vector<std::uint8_t> rgb(image->values.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = to_8bit(image->values[i]);
  if (texture_ == 0) glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, image->width, image->height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               rgb.data());
  glGenerateMipmap(GL_TEXTURE_2D);
  return texture_;
}

void WindowGrab::request(const std::filesystem::path& path, bool notify) {
  path_ = path;
  notify_ = notify;
}

void WindowGrab::take(const std::function<Image()>& pixels, Actions& actions,
                      const std::string& altered) {
  if (!requested()) return;
  const std::filesystem::path path = std::exchange(path_, {});
  try {
    std::error_code ignored;  // write_image() reports a missing folder
    std::filesystem::create_directories(path.parent_path(), ignored);
    write_image(pixels(), path,
                altered.empty() ? ImageMetadata() : ImageMetadata{{"Altered", altered}});
    if (notify_) actions.push_back(call(action::notify_file, path, std::string()));
  } catch (const Error& error) {
    actions.push_back(call(action::notify_error, std::string(error.what())));
  }
}

}  // namespace qs
