// SPDX-License-Identifier: MIT
#include "app/cli/lens_options.h"

#include <algorithm>
#include <memory>

#include "app/cli/camera_choice.h"
#include "app/framing/first_view.h"
#include "app/framing/up_axis.h"
#include "base/fail.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"

namespace qs {
namespace {

constexpr double kUsualFisheye = 180;
constexpr int kUsualPanorama = 1024;  // px, height of one eye's picture

// Any other name is a camera model with its parameters.
LensView lens_of(const LensOptions& options) {
  if (options.is_panorama()) return panorama_view(options.panorama_degrees());
  if (options.lens == "fisheye") return fisheye_view(options.fov.value_or(kUsualFisheye));
  if (options.lens == "orthographic") return parallel_view(options.height.value_or(1));
  if (options.lens.find(',') == std::string::npos)
    fail(ErrorKind::usage,
         "--lens: '{}' is none of pinhole, equirectangular, fisheye, orthographic, and not "
         "MODEL,WIDTH,HEIGHT,PARAMETERS",
         options.lens);
  return photograph_view(parse_lens(options.lens, "--lens"));
}

// Up in the world: declared, or as the cameras stand.
glm::dvec3 up_of(const FrameOptions& frame, const Session& session) {
  const Scene& scene = *session.scene;
  if (const auto up = declared_up(frame.up, scene.vertical_axis)) return *up;
  const std::vector<Camera> cameras = cameras_of(frame, scene);
  const glm::dvec3 usual = world_up("");
  return cameras.empty() ? usual : cameras_up(cameras, usual);
}

}  // namespace

void declare_lens_options(Options& options, LensOptions& lens) {
  options.text("--lens", "NAME", lens.lens,
               "draws through a lens: equirectangular, fisheye, orthographic, or "
               "MODEL,WIDTH,HEIGHT,PARAMETERS as COLMAP has them (default: pinhole; for one "
               "--camera-index of render the lens of that camera if it is too wide)",
               {"fisheye", "equirectangular", "orthographic",
                "OPENCV_FISHEYE,100,80,40,40,50,40,0.01,0,0,0"});
  options.offers({"pinhole", "equirectangular", "fisheye", "orthographic"});
  options.real("--fov", "DEGREES", 1, 360, lens.fov,
               "of a fisheye, across the shorter side (default: 180); of equirectangular 180 or "
               "360 (default)",
               {"180"});
  options.real("--height", "UNITS", 1e-12, 1e12, lens.height,
               "world units from the top to the bottom of an orthographic picture", {"2", "5"});
  options.flag("--level", lens.level, "keeps the horizon of a lens level");
  options.choice(
      "--stereo", {"off", "over-under"}, [&lens](int chosen) { lens.stereo = chosen == 1; },
      "over-under: VR180, the pictures of the left eye above those of the right one; needs --lens "
      "equirectangular --fov 180 and --eye-distance");
  options.real("--eye-distance", "UNITS", 1e-12, 1e12, lens.eye_distance,
               "world units between the eyes of --stereo", {"0.065", "0.1"});
}

void check_lens(const char* command, const LensOptions& lens, FrameOptions& frame) {
  const double degrees = lens.panorama_degrees();
  const bool is_half = degrees == 180;
  check_rules(command,
              {{lens.fov && lens.lens != "fisheye" && !lens.is_panorama(),
                "--fov is of --lens fisheye and equirectangular"},
               {lens.is_panorama() && degrees != 360 && !is_half,
                "--lens equirectangular has a --fov of 180 or 360 degrees"},
               {lens.height.has_value() != (lens.lens == "orthographic"),
                "--lens orthographic and --height UNITS, of its picture, need each other"},
               {lens.level && !lens.is_drawn(), "--level needs a --lens"},
               {lens.stereo && !(lens.is_panorama() && is_half),
                "--stereo over-under needs --lens equirectangular --fov 180"},
               {lens.stereo != lens.eye_distance.has_value(),
                "--stereo over-under and --eye-distance UNITS need each other"},
               {lens.has_faces() && frame.settings.occlusion,
                "--occlusion on leaves out nothing with a --lens"},
               {frame.network != NetworkUse::never && (lens.stereo || lens.lens == "orthographic"),
                "--exact-color knows the colours from one point: it excludes --stereo and --lens "
                "orthographic"}});
  if (lens.is_drawn()) lens_of(lens);  // throws
  if (!frame.size && lens.lens.find(',') != std::string::npos)
    frame.size = glm::ivec2(parse_lens(lens.lens, "--lens").size_px);
  if (!lens.is_panorama()) return;
  const glm::ivec2 shape(is_half ? 1 : 2, lens.stereo ? 2 : 1);
  if (!frame.size) frame.size = kUsualPanorama * shape;
  if (frame.size->x * shape.y != frame.size->y * shape.x)
    fail(ErrorKind::usage, "{}: --lens equirectangular {}: {}, but --size is {}x{}", command,
         lens.stereo ? "with two eyes is half as wide as high"
         : is_half   ? "of 180 degrees is as wide as high"
                     : "is twice as wide as high",
         fmt::format("such as {}x{}", kUsualPanorama * shape.x, kUsualPanorama * shape.y),
         frame.size->x, frame.size->y);
}

void use_own_lens(LensOptions& lens, const CameraChoice& cameras, const FrameOptions& frame) {
  if (!lens.lens.empty() || cameras.indices.size() != 1 || cameras.json || cameras.path ||
      cameras.all)
    return;
  const auto file = cameras_file(frame, frame.scene);
  if (!file) return;
  const CameraSet set = read_camera_set(*file);
  const auto index = static_cast<std::size_t>(cameras.indices[0]);
  if (index >= set.cameras.size()) return;  // named when the views are chosen
  const LensCamera& camera = set.cameras[index];
  if (!camera.lens || camera.lens->face != kAllFaces) return;
  lens.lens = photograph_view(*camera.lens).text;
  warn(fmt::format(
      "camera {}{} is drawn through its lens, --lens {}; --lens pinhole draws its "
      "front face",
      index, camera.camera.name.empty() ? "" : " (" + camera.camera.name + ")", lens.lens));
}

void set_lens(const LensOptions& lens, const FrameOptions& frame, Session& session) {
  if (!lens.is_drawn()) return;
  LensView view = lens_of(lens);
  view.eye_distance = lens.eye_distance.value_or(0);
  if (lens.level) view.up = up_of(frame, session);
  session.settings.lens = std::make_shared<const LensView>(std::move(view));
}

}  // namespace qs
