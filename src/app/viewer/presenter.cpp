// SPDX-License-Identifier: MIT
#include "app/viewer/presenter.h"

#include <array>
#include <fstream>
#include <iterator>

#include <epoxy/gl.h>

#include "app/assets.h"
#include "app/picture/colormap.h"
#include "raster/scene/fail.h"

namespace qs {
namespace {

constexpr int kColors = 256;

unsigned compiled(GLenum kind, const char* name) {
  const auto path = find_asset(std::string("shaders/") + name);
  if (!path) fail(ErrorKind::device, "view: the file shaders/{} of the program is missing", name);
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

unsigned linked(unsigned vertex, unsigned fragment) {
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

}  // namespace

Presenter::Presenter() {
  program_ = linked(compiled(GL_VERTEX_SHADER, "present.vert"),
                    compiled(GL_FRAGMENT_SHADER, "present.frag"));
  glUseProgram(program_);
  glUniform1i(glGetUniformLocation(program_, "picture"), 0);
  glUniform1i(glGetUniformLocation(program_, "heat"), 1);
  glUniform1i(glGetUniformLocation(program_, "colors"), 2);
  heat_maximum_uniform_ = glGetUniformLocation(program_, "heat_maximum");
  heat_cells_uniform_ = glGetUniformLocation(program_, "heat_cells");
  glGenVertexArrays(1, &empty_vertices_);
  glGenQueries(1, &query_);
  glGenBuffers(1, &pixels_);
  picture_ = new_texture(GL_TEXTURE_2D, GL_LINEAR);
  heat_ = new_texture(GL_TEXTURE_2D, GL_NEAREST);
  colors_ = new_texture(GL_TEXTURE_1D, GL_LINEAR);
  std::array<glm::vec3, kColors> colors;
  for (int i = 0; i < kColors; ++i)
    colors[static_cast<std::size_t>(i)] = viridis(static_cast<float>(i) / (kColors - 1));
  glTexImage1D(GL_TEXTURE_1D, 0, GL_RGB8, kColors, 0, GL_RGB, GL_FLOAT, colors.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
}

Presenter::~Presenter() {
  glDeleteTextures(1, &picture_);
  glDeleteTextures(1, &heat_);
  glDeleteTextures(1, &colors_);
  glDeleteQueries(1, &query_);
  glDeleteBuffers(1, &pixels_);
  glDeleteVertexArrays(1, &empty_vertices_);
  glDeleteProgram(program_);
}

void Presenter::show(FrameReply reply, const Scale& scale) {
  next_ = std::move(reply);
  heat_maximum_ = next_->shown.heatmap ? static_cast<float>(scale.maximum) : 0;
}

// The pixels of the newest reply, in a texture of ours or in the one they were drawn into.
void Presenter::upload() {
  const FrameReply reply = *std::exchange(next_, std::nullopt);
  shown_ = reply.texture.name != 0 ? reply.texture.name : picture_;
  glBindTexture(GL_TEXTURE_2D, shown_);
  width_ = reply.width;
  height_ = reply.height;
  if (shown_ == picture_) {
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, pixels_);
    glBufferData(GL_PIXEL_UNPACK_BUFFER, static_cast<GLsizeiptr>(reply.rgba.size()),
                 reply.rgba.data(), GL_STREAM_DRAW);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width_, height_, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 nullptr);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  }
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                  reply.shown.heatmap ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR);
  if (!reply.shown.heatmap) return;
  glGenerateMipmap(GL_TEXTURE_2D);
  const Heatmap& map = *reply.shown.heatmap;
  const std::vector<float> values(map.values.begin(), map.values.end());
  glBindTexture(GL_TEXTURE_2D, heat_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, map.columns, map.rows, 0, GL_RED, GL_FLOAT,
               values.data());
  heat_cells_ = glm::vec2(width_, height_) / static_cast<float>(map.cell_px);
}

void Presenter::draw(int width, int height) {
  glViewport(0, 0, width, height);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  if (next_) {
    begin_timing();
    upload();
  }
  if (width_ == 0) {
    glClearColor(0.075f, 0.08f, 0.095f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    return;
  }
  glUseProgram(program_);
  glUniform1f(heat_maximum_uniform_, heat_maximum_);
  glUniform2f(heat_cells_uniform_, heat_cells_.x, heat_cells_.y);
  glActiveTexture(GL_TEXTURE2);
  glBindTexture(GL_TEXTURE_1D, colors_);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, heat_);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, shown_);
  glBindVertexArray(empty_vertices_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
  end_timing();
}

// One query at a time: a new one begins when the last one's result was read.
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

}  // namespace qs
