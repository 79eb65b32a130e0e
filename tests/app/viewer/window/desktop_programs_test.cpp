// SPDX-License-Identifier: MIT
//
// Opening files in the desktop's programs, with scripts in the place of xdg-open.
#include <chrono>
#include <fstream>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/window/desktop.h"
#include "base/error.h"
#include "io/bytes/json_text.h"
#include "support/recording_host.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class DesktopProgramsTest : public testing::Test {
 protected:
  std::string script(const std::string& lines) {
    const std::filesystem::path file = folder_ / "opener";
    std::ofstream(file) << "#!/bin/sh\n" << lines << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file.string();
  }
  // The messages after everything has ended.
  std::vector<Toast> messages_of(DesktopPrograms& programs) {
    for (int i = 0; i < 2000 && programs.busy(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      Actions actions;
      programs.take_reports(actions);
      for (const Action& action : actions) store_.apply(action, host_);
    }
    EXPECT_FALSE(programs.busy());
    return store_.viewer().toasts;
  }

  TemporaryFolder folder_;
  ViewerStore store_{Viewer()};
  test::RecordingHost host_;
};

TEST_F(DesktopProgramsTest, get_the_path_and_say_nothing_if_all_is_well) {
  DesktopPrograms programs(script("echo \"$1\" > " + (folder_ / "seen").string()));
  programs.open(folder_ / "a b.png");
  EXPECT_THAT(messages_of(programs), IsEmpty());
  EXPECT_EQ(read_text_file(folder_ / "seen", 1000), (folder_ / "a b.png").string() + "\n");
}

// Programs of this name in a PATH of their own write their arguments and their input to files.
class CopyPicture : public DesktopProgramsTest {
 protected:
  CopyPicture() : path_variable_(std::getenv("PATH")) {
    std::ofstream(folder_ / "figure.png") << "the bytes of a picture";
    setenv("PATH", (folder_.path().string() + ":/bin:/usr/bin").c_str(), 1);
    unsetenv("WAYLAND_DISPLAY");
  }
  ~CopyPicture() override { setenv("PATH", path_variable_.c_str(), 1); }
  void install(const std::string& name, const std::string& end = "") {
    std::filesystem::rename(script(fmt::format("echo {0} \"$@\" > {1}/words; cat > {1}/input; {2}",
                                               name, folder_.path().string(), end)),
                            folder_ / name);
  }
  std::string text(const char* file) const { return read_text_file(folder_ / file, 1000); }

 private:
  std::string path_variable_;
};

TEST_F(CopyPicture, gives_it_to_xclip_or_to_wl_copy_on_wayland) {
  install("xclip");
  EXPECT_TRUE(copy_picture(folder_ / "figure.png"));
  EXPECT_EQ(text("words"), "xclip -selection clipboard -t image/png\n");
  EXPECT_EQ(text("input"), "the bytes of a picture");
  install("wl-copy");
  setenv("WAYLAND_DISPLAY", "wayland-0", 1);
  EXPECT_TRUE(copy_picture(folder_ / "figure.png"));
  EXPECT_EQ(text("words"), "wl-copy --type image/png\n");
  install("wl-copy", "exit 1");
  EXPECT_TRUE(copy_picture(folder_ / "figure.png")) << "through xclip";
  EXPECT_EQ(text("words"), "xclip -selection clipboard -t image/png\n");
}

TEST_F(CopyPicture, is_false_without_a_program_that_can) {
  install("xclip", "exit 1");
  EXPECT_FALSE(copy_picture(folder_ / "figure.png"));
  std::filesystem::remove(folder_ / "xclip");
  setenv("PATH", folder_.path().c_str(), 1);
  EXPECT_FALSE(copy_picture(folder_ / "figure.png"));
  EXPECT_THROW(copy_picture(folder_ / "missing.png"), Error);
}

TEST_F(DesktopProgramsTest, a_failure_is_one_sentence) {
  DesktopPrograms programs(script("exit 3"));
  programs.open("/a.png");
  const std::vector<Toast> messages = messages_of(programs);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_TRUE(messages[0].error);
  EXPECT_THAT(messages[0].text, HasSubstr("/a.png: cannot be opened: "));
  EXPECT_THAT(messages[0].text, HasSubstr("ended with exit code 3"));
  DesktopPrograms missing("no-such-program-here");
  try {
    missing.open("/a.png");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/a.png: cannot be opened: no-such-program-here does not "
                                        "start"));
  }
}

}  // namespace
}  // namespace qs
