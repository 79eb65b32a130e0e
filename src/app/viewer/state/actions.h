// SPDX-License-Identifier: MIT
//
// Everything that can happen to the viewer: what people do, and what the render thread and the
// loader report. apply() is the one place that changes a Viewer; it never waits, draws or reads.
// To add an action: a struct, an entry in Action, its apply in actions.cpp, and a row of kBindings
// if a key should do it.
#pragma once

#include <variant>

#include "app/viewer/state/viewer.h"

namespace qs {
namespace action {

// ---- looking
// -------------------------------------------------------------------------------------
struct SetMode {
  CullMode mode;
};
struct PeekPreviousMode {
  bool held = true;
};
struct ToggleHeatmap {};
struct NextHeatmap {};
struct ChangeSplit {
  Split split;
};
struct FlipSplit {};
struct NextSplitView {};
struct ScaleSplats {
  float factor;
};
struct ChangeSettings {
  RenderSettings settings;
};
struct ChangeBackend {
  Backend backend;
};

// ---- moving: pixels of the cursor, notches of the wheel
// ------------------------------------------
struct Orbit {
  glm::dvec2 pixels;
};
struct Look {
  glm::dvec2 pixels;
};
struct Pan {
  glm::dvec2 pixels;
};
struct Dolly {
  double notches;
};
struct ChangeFov {
  double notches;
};
struct Roll {
  double notches;
};
struct Fly {
  glm::dvec3 direction;  ///< right, down, forward; each -1..1
  double seconds, factor = 1;
};
struct ToggleNavigation {};
struct FrameScene {};
struct GoHome {};
enum class CameraStep { previous, next, first, last, nearest };
struct StepCamera {
  CameraStep step;
};
struct GoToCamera {
  int index;
};
struct PickPivot {
  glm::dvec2 pixel;
};
struct SetPivot {
  glm::dvec3 point;
};
struct SetCamera {  ///< any size; it is fitted to the window
  Camera camera;
};
struct Resize {
  int width, height;
};

// ---- windows and files
// ------------------------------------------------------------------------------
struct TogglePanel {
  bool Panels::*panel;
};
struct TogglePhotograph {};
struct ToggleFullscreen {};
struct TakeScreenshot {
  bool with_ui;
};
struct CopyCamera {};
struct PasteCamera {};
struct Open {
  std::filesystem::path path;
};
struct Reload {};
struct NextAxes {};  ///< reads the file again as if its axes were others
struct CancelLoading {};
struct Quit {};
struct ToggleOption {
  bool Viewer::*option;
};
struct SetPhotographOpacity {
  float opacity;
};

// ---- measuring and paths
// ----------------------------------------------------------------------------
struct ToggleZoomRecorder {};
struct BenchView {};
struct InspectPixel {  ///< a click on the picture; does nothing while the inspector is closed
  glm::dvec2 pixel;
};
struct InspectGaussian {  ///< in the pixel that is being inspected
  std::uint32_t gaussian;
};
struct AskOracle {
  bool around_cursor = false;  ///< only there, which is quicker
};
struct AddKeyframe {};
struct RemoveKeyframe {
  std::size_t index;
};
struct TogglePlayback {};
struct Seek {
  double time;
};
struct SaveKeyframes {};
struct SetKeyframes {
  std::vector<Keyframe> keyframes;
};

// ---- reports
// -----------------------------------------------------------------------------------------
struct Tick {
  double now, seconds;  ///< since the start, since the last tick
};
struct SetLoading {
  std::optional<Loading> loading;
};
struct SceneOpened {
  ViewedScene scene;
  RenderSettings settings;
  Backend backend;
};
struct BackendChanged {
  Backend backend;
};
struct CamerasOpened {
  std::vector<Camera> cameras;
  std::filesystem::path file;
  std::map<int, std::filesystem::path> photographs;
};
struct FrameShown {
  ShownFrame frame;
};
struct NumbersMeasured {
  ModeNumbers numbers;
};
struct WindowMeasured {  ///< members of Viewer
  double display_fps;
  float present_ms;
};
struct MemoryMeasured {
  std::uint64_t process_bytes, gpu_bytes;
};
struct MeasuringChanged {
  bool running;
};
struct PixelInspected {
  InspectedView view;
};
struct OracleAnswered {
  OracleAnswer answer;
};
struct ZoomStepped {
  int steps;
  std::vector<BenchRow> rows;  ///< of the new step
};
struct ZoomEnded {
  std::filesystem::path folder;  ///< empty when nothing was saved
};
struct Say {
  std::string text;
  bool error = false;
};

}  // namespace action

using Action = std::variant<
    action::SetMode, action::PeekPreviousMode, action::ToggleHeatmap, action::NextHeatmap,
    action::ChangeSplit, action::FlipSplit, action::NextSplitView, action::ScaleSplats,
    action::ChangeSettings, action::ChangeBackend, action::Orbit, action::Look, action::Pan,
    action::Dolly, action::ChangeFov, action::Roll, action::Fly, action::ToggleNavigation,
    action::FrameScene, action::GoHome, action::StepCamera, action::GoToCamera, action::PickPivot,
    action::SetPivot, action::SetCamera, action::Resize, action::TogglePanel,
    action::TogglePhotograph, action::ToggleFullscreen, action::TakeScreenshot, action::CopyCamera,
    action::PasteCamera, action::Open, action::Reload, action::NextAxes, action::CancelLoading,
    action::Quit, action::ToggleOption, action::SetPhotographOpacity, action::ToggleZoomRecorder,
    action::BenchView, action::InspectPixel, action::InspectGaussian, action::AskOracle,
    action::AddKeyframe, action::RemoveKeyframe, action::TogglePlayback, action::Seek,
    action::SaveKeyframes, action::SetKeyframes, action::Tick, action::SetLoading,
    action::SceneOpened, action::BackendChanged, action::CamerasOpened, action::FrameShown,
    action::NumbersMeasured, action::WindowMeasured, action::MemoryMeasured,
    action::MeasuringChanged, action::PixelInspected, action::OracleAnswered, action::ZoomStepped,
    action::ZoomEnded, action::Say>;

using Actions = std::vector<Action>;

void apply(Viewer& viewer, const Action& action);

}  // namespace qs
