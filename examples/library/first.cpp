// SPDX-License-Identifier: MIT
// Draws the first camera of a scene: first_cpp SCENE OUT.ppm
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <vector>

#include <quadsplat/quadsplat.hpp>

int main(int argc, char** argv) try {
  if (argc != 3) return QS_USAGE;
  quadsplat::Context context;
  quadsplat::Scene scene = context.load(argv[1]);
  const QsCamera camera = quadsplat::read_cameras(scene.facts().cameras_path).at(0);

  std::vector<std::uint8_t> pixels(3u * static_cast<unsigned>(camera.width * camera.height));
  auto counts = quadsplat::sized<QsCounts>();
  auto picture = quadsplat::sized<QsPicture>();
  picture.color = quadsplat::array_of(pixels.data(), {camera.height, camera.width, 3});
  picture.counts = &counts;
  scene.render(camera, picture);
  std::cout << counts.visible << " of " << counts.gaussians << " Gaussians are visible, " << counts.tile_pairs
            << " tile pairs\n";

  std::ofstream file(argv[2], std::ios::binary);
  file << "P6\n" << camera.width << ' ' << camera.height << "\n255\n";
  file.write(reinterpret_cast<const char*>(pixels.data()), static_cast<std::streamsize>(pixels.size()));
  return 0;
} catch (const quadsplat::Error& error) {
  std::cerr << error.what() << '\n';
  return error.code();
} catch (const std::exception& error) {  // no camera
  std::cerr << error.what() << '\n';
  return QS_INPUT;
}
