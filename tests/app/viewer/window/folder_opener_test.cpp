// SPDX-License-Identifier: MIT
//
// Opening a folder with programs in place of xdg-open.
#include "app/viewer/window/folder_opener.h"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class FolderOpenerTest : public testing::Test {
 protected:
  FolderOpenerTest() : path_variable_(std::getenv("PATH")) {
    setenv("PATH", folder_.path().c_str(), 1);
  }
  ~FolderOpenerTest() override { setenv("PATH", path_variable_.c_str(), 1); }

  void make_opener(const std::string& script) {
    std::ofstream(folder_ / "xdg-open") << "#!/bin/sh\n" << script << "\n";
    std::filesystem::permissions(folder_ / "xdg-open", std::filesystem::perms::owner_all);
  }

  // The messages once `done` is true, or after a second.
  template <class Done>
  std::vector<std::string> messages(const Done& done) {
    test::Driven driven;
    FolderOpener opener;
    opener.open("/some/folder");
    for (int i = 0; i < 1000 && !done(driven); ++i) {
      Actions actions;
      opener.take_report(actions);
      driven.apply_all(actions);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    std::vector<std::string> texts;
    for (const Toast& toast : driven.viewer.toasts) texts.push_back(toast.text);
    return texts;
  }

  TemporaryFolder folder_;

 private:
  std::string path_variable_;
};

TEST_F(FolderOpenerTest, passes_the_folder_to_xdg_open_and_says_nothing) {
  make_opener("echo \"$1\" > " + (folder_ / "seen").string());
  const auto seen = [&](const test::Driven&) {
    std::string word;
    std::ifstream(folder_ / "seen") >> word;
    return word == "/some/folder";
  };
  EXPECT_THAT(messages(seen), IsEmpty());
  EXPECT_TRUE(seen(test::Driven()));
}

TEST_F(FolderOpenerTest, a_failure_is_told_once_with_the_folder) {
  const auto told = [](const test::Driven& driven) { return !driven.viewer.toasts.empty(); };
  const std::vector<std::string> missing = messages(told);
  ASSERT_THAT(missing, SizeIs(1));
  EXPECT_THAT(missing[0], HasSubstr("/some/folder"));
  make_opener("exit 4");
  const std::vector<std::string> failed = messages(told);
  ASSERT_THAT(failed, SizeIs(1));
  EXPECT_THAT(failed[0], HasSubstr("/some/folder"));
}

}  // namespace
}  // namespace qs
