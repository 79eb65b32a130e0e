// SPDX-License-Identifier: MIT
// Draws the first camera of a scene in 800 x 600 pixels: first_cpp SCENE OUT.ppm
#include <cstdint>
#include <fstream>
#include <iostream>
#include <quadsplat/quadsplat.hpp>
#include <vector>

int main(int argc, char** argv) try {
  if (argc != 3) return QS_USAGE;
  quadsplat::Context context;
  quadsplat::Scene scene = context.load(argv[1]);
  QsCamera camera = quadsplat::read_cameras(scene.facts().cameras_path).at(0);
  quadsplat::check(qs_camera_resize, &camera, 800, 600);
  std::vector<std::uint8_t> pixels(800 * 600 * 3);
  auto picture = quadsplat::sized<QsPicture>();
  picture.color = quadsplat::array_of(pixels.data(), {600, 800, 3});
  scene.render(camera, picture);
  std::ofstream file(argv[2], std::ios::binary);
  file << "P6 800 600 255\n";
  file.write(reinterpret_cast<const char*>(pixels.data()), 800 * 600 * 3);
} catch (const quadsplat::Error& error) {
  std::cerr << error.what() << '\n';
  return error.code();
}
