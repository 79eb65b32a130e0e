// SPDX-License-Identifier: MIT
// Needs QUADSPLAT_PORTAL.
//
// The desktop's own dialog, with a portal of the test's on a message bus of its own.
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <string_view>

#include <dbus/dbus.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/viewer/window/desktop.h"
#include "support/recording_host.h"

namespace qs {
namespace {

using namespace std::chrono_literals;
using testing::SizeIs;

/// dbus-daemon; the session's bus while it lives.
class SessionBus {
 public:
  SessionBus() {
    if (const char* kept = std::getenv("DBUS_SESSION_BUS_ADDRESS")) kept_ = kept;
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return;
    daemon_ = fork();
    if (daemon_ == 0) {
      dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
      dup2(ends[1], 3);
      execlp("dbus-daemon", "dbus-daemon", "--session", "--nofork", "--print-address=3",
             static_cast<char*>(nullptr));
      _exit(127);
    }
    close(ends[1]);
    char c = 0;
    while (read(ends[0], &c, 1) == 1 && c != '\n') address_ += c;
    close(ends[0]);
    setenv("DBUS_SESSION_BUS_ADDRESS", address_.c_str(), 1);
  }
  ~SessionBus() {
    kill(daemon_, SIGTERM);
    waitpid(daemon_, nullptr, 0);
    if (kept_.empty()) {
      unsetenv("DBUS_SESSION_BUS_ADDRESS");
    } else {
      setenv("DBUS_SESSION_BUS_ADDRESS", kept_.c_str(), 1);
    }
  }
  SessionBus(const SessionBus&) = delete;
  SessionBus& operator=(const SessionBus&) = delete;

  bool runs() const { return !address_.empty(); }
  const std::string& address() const { return address_; }

 private:
  std::string address_, kept_;
  pid_t daemon_ = -1;
};

/// Answers OpenFile at once with `uri`; without one, as if the user had closed the dialog.
class FakePortal {
 public:
  FakePortal(const SessionBus& bus, std::string uri, dbus_uint32_t version = 3)
      : uri_(std::move(uri)), version_(version) {
    bus_ = dbus_connection_open_private(bus.address().c_str(), nullptr);
    dbus_bus_register(bus_, nullptr);
    dbus_connection_set_exit_on_disconnect(bus_, FALSE);
    dbus_bus_request_name(bus_, "org.freedesktop.portal.Desktop", 0, nullptr);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested() && dbus_connection_read_write(bus_, 10) != FALSE) {
        while (DBusMessage* message = dbus_connection_pop_message(bus_)) {
          answer(message);
          dbus_message_unref(message);
        }
      }
    });
  }
  ~FakePortal() {
    thread_ = {};
    dbus_connection_close(bus_);
    dbus_connection_unref(bus_);
  }
  FakePortal(const FakePortal&) = delete;
  FakePortal& operator=(const FakePortal&) = delete;

  std::string folder;              ///< in which the last dialog was asked to begin
  bool directory = false;          ///< the last dialog was asked to choose a folder
  bool refuses = false;            ///< OpenFile fails
  std::atomic<bool> mute = false;  ///< nothing is answered
  std::atomic<int> calls = 0;      ///< all
  std::atomic<int> shown = 0;

 private:
  void send(DBusMessage* message) {
    dbus_connection_send(bus_, message, nullptr);
    dbus_connection_flush(bus_);
    dbus_message_unref(message);
  }

  void answer(DBusMessage* call) {
    if (dbus_message_get_type(call) == DBUS_MESSAGE_TYPE_METHOD_CALL) ++calls;
    if (mute) return;
    if (dbus_message_is_method_call(call, "org.freedesktop.DBus.Properties", "Get") != FALSE) {
      DBusMessage* reply = dbus_message_new_method_return(call);
      DBusMessageIter arguments, value;
      dbus_message_iter_init_append(reply, &arguments);
      dbus_message_iter_open_container(&arguments, DBUS_TYPE_VARIANT, "u", &value);
      dbus_message_iter_append_basic(&value, DBUS_TYPE_UINT32, &version_);
      dbus_message_iter_close_container(&arguments, &value);
      send(reply);
    }
    if (dbus_message_is_method_call(call, "org.freedesktop.portal.FileChooser", "OpenFile") ==
        FALSE)
      return;
    if (refuses) return send(dbus_message_new_error(call, DBUS_ERROR_FAILED, "no"));
    read_options(call);
    const char* request = "/org/freedesktop/portal/desktop/request/1";
    DBusMessage* reply = dbus_message_new_method_return(call);
    dbus_message_append_args(reply, DBUS_TYPE_OBJECT_PATH, &request, DBUS_TYPE_INVALID);
    send(reply);
    respond(request, dbus_message_get_sender(call));
    ++shown;
  }

  void read_options(DBusMessage* call) {
    ASSERT_STREQ(dbus_message_get_signature(call), "ssa{sv}");
    DBusMessageIter at, options;
    dbus_message_iter_init(call, &at);
    dbus_message_iter_next(&at);
    dbus_message_iter_next(&at);
    dbus_message_iter_recurse(&at, &options);
    directory = false;
    for (; dbus_message_iter_get_arg_type(&options) == DBUS_TYPE_DICT_ENTRY;
         dbus_message_iter_next(&options)) {
      DBusMessageIter entry, value, bytes;
      const char *key = nullptr, *text = nullptr;
      dbus_message_iter_recurse(&options, &entry);
      dbus_message_iter_get_basic(&entry, &key);
      dbus_message_iter_next(&entry);
      dbus_message_iter_recurse(&entry, &value);
      if (std::string_view(key) == "directory") {
        dbus_bool_t is_wanted = FALSE;
        dbus_message_iter_get_basic(&value, &is_wanted);
        directory = is_wanted != FALSE;
        continue;
      }
      int count = 0;
      dbus_message_iter_recurse(&value, &bytes);
      dbus_message_iter_get_fixed_array(&bytes, &text, &count);
      folder.assign(text, static_cast<std::size_t>(count));
    }
  }

  void respond(const char* request, const char* receiver) {
    DBusMessage* signal =
        dbus_message_new_signal(request, "org.freedesktop.portal.Request", "Response");
    dbus_message_set_destination(signal, receiver);
    DBusMessageIter arguments, results, entry, value, list;
    const dbus_uint32_t outcome = uri_.empty() ? 1 : 0;
    const char *const key = "uris", *const uri = uri_.c_str();
    dbus_message_iter_init_append(signal, &arguments);
    dbus_message_iter_append_basic(&arguments, DBUS_TYPE_UINT32, &outcome);
    dbus_message_iter_open_container(&arguments, DBUS_TYPE_ARRAY, "{sv}", &results);
    if (!uri_.empty()) {
      dbus_message_iter_open_container(&results, DBUS_TYPE_DICT_ENTRY, nullptr, &entry);
      dbus_message_iter_append_basic(&entry, DBUS_TYPE_STRING, &key);
      dbus_message_iter_open_container(&entry, DBUS_TYPE_VARIANT, "as", &value);
      dbus_message_iter_open_container(&value, DBUS_TYPE_ARRAY, "s", &list);
      dbus_message_iter_append_basic(&list, DBUS_TYPE_STRING, &uri);
      dbus_message_iter_close_container(&value, &list);
      dbus_message_iter_close_container(&entry, &value);
      dbus_message_iter_close_container(&results, &entry);
    }
    dbus_message_iter_close_container(&arguments, &results);
    send(signal);
  }

  std::string uri_;
  dbus_uint32_t version_;
  DBusConnection* bus_;
  std::jthread thread_;
};

bool becomes(const std::function<bool()>& condition, std::chrono::milliseconds limit = 10s) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(1ms);
  return condition();
}

Actions reports_of(DesktopDialog& dialog) {
  Actions actions;
  becomes([&] { return dialog.take_reports(actions), !actions.empty(); });
  return actions;
}

TEST(DesktopDialog, opens_the_file_that_the_portal_s_dialog_returns_every_time) {
  const SessionBus bus;
  if (!bus.runs()) GTEST_SKIP() << "dbus-daemon is not installed";
  const FakePortal portal(bus, "file:///tmp/my%20scenes/%C3%A4.ply");
  std::atomic<int> woken = 0;
  DesktopDialog dialog([&] { ++woken; });
  ASSERT_TRUE(becomes([&] { return dialog.is_available(Choosing::scene); }));
  for (int time = 1; time <= 2; ++time) {
    dialog.show("/tmp/my scenes", Choosing::scene);
    ViewerStore store{Viewer()};
    test::RecordingHost host;
    for (const Action& action : reports_of(dialog)) store.apply(action, host);
    ASSERT_THAT(host.opened, SizeIs(1));
    EXPECT_EQ(host.opened[0].path, "/tmp/my scenes/\u00e4.ply");
    EXPECT_EQ(portal.folder, std::string("/tmp/my scenes") + '\0');
    EXPECT_GE(woken, time);
  }
}

TEST(DesktopDialog, chooses_the_folder_of_the_photographs_if_the_portal_can) {
  const SessionBus bus;
  if (!bus.runs()) GTEST_SKIP() << "dbus-daemon is not installed";
  {
    const FakePortal portal(bus, "file:///data/photos");
    DesktopDialog dialog([] {});
    ASSERT_TRUE(becomes([&] { return dialog.is_available(Choosing::photographs); }));
    dialog.show("/data", Choosing::photographs);
    ViewerStore store{Viewer()};
    test::RecordingHost host;
    for (const Action& action : reports_of(dialog)) store.apply(action, host);
    EXPECT_TRUE(portal.directory);
    EXPECT_EQ(portal.folder, std::string("/data") + '\0');
    EXPECT_EQ(store.viewer().train_form.data, "/data/photos");
    EXPECT_TRUE(host.opened.empty());
  }
  const FakePortal old(bus, "file:///data/photos", 2);
  DesktopDialog dialog([] {});
  ASSERT_TRUE(becomes([&] { return dialog.is_available(Choosing::scene); }));
  EXPECT_FALSE(dialog.is_available(Choosing::photographs)) << "the viewer's own dialog opens";
}

TEST(DesktopDialog, closing_the_portal_s_dialog_opens_nothing) {
  const SessionBus bus;
  if (!bus.runs()) GTEST_SKIP() << "dbus-daemon is not installed";
  const FakePortal portal(bus, "");
  DesktopDialog dialog([] {});
  ASSERT_TRUE(becomes([&] { return dialog.is_available(Choosing::scene); }));
  dialog.show("/tmp", Choosing::scene);
  ASSERT_TRUE(becomes([&] { return portal.shown == 1; }));
  // It can be shown again. While the first dialog closes, show() does nothing, so it is called
  // until the portal has shown another dialog. The portal may have shown more than two by then.
  EXPECT_TRUE(becomes([&] { return dialog.show("/tmp", Choosing::scene), portal.shown >= 2; }));
  Actions actions;
  dialog.take_reports(actions);
  EXPECT_TRUE(actions.empty());
  EXPECT_TRUE(dialog.is_available(Choosing::scene));
}

TEST(DesktopDialog, a_portal_that_fails_gives_way_to_the_viewer_s_own_dialog) {
  const SessionBus bus;
  if (!bus.runs()) GTEST_SKIP() << "dbus-daemon is not installed";
  FakePortal portal(bus, "");
  portal.refuses = true;
  DesktopDialog dialog([] {});
  ASSERT_TRUE(becomes([&] { return dialog.is_available(Choosing::scene); }));
  dialog.show("/tmp", Choosing::scene);
  ViewerStore store{Viewer()};
  test::RecordingHost host;
  for (const Action& action : reports_of(dialog)) store.apply(action, host);
  EXPECT_TRUE(store.viewer().panels.open);
  EXPECT_EQ(store.viewer().choosing, Choosing::scene);
  EXPECT_FALSE(dialog.is_available(Choosing::scene));
}

TEST(DesktopDialog, ends_without_waiting_for_a_portal_that_does_not_answer) {
  const SessionBus bus;
  if (!bus.runs()) GTEST_SKIP() << "dbus-daemon is not installed";
  for (const bool is_open : {false, true}) {
    FakePortal portal(bus, "");
    portal.mute = !is_open;
    std::optional<DesktopDialog> dialog;
    dialog.emplace([] {});
    if (is_open) {
      ASSERT_TRUE(becomes([&] { return dialog->is_available(Choosing::scene); }));
      portal.mute = true;
      dialog->show("/tmp", Choosing::scene);
    }
    const int before = is_open ? 1 : 0;
    ASSERT_TRUE(becomes([&] { return portal.calls > before; }));
    const auto begin = std::chrono::steady_clock::now();
    dialog.reset();
    // The portal has 5 s to answer.
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 3s);
  }
}

TEST(DesktopDialog, is_not_available_on_a_bus_without_a_portal_and_without_a_bus) {
  {
    const SessionBus bus;
    if (!bus.runs()) GTEST_SKIP() << "dbus-daemon is not installed";
    const DesktopDialog dialog([] {});
    EXPECT_FALSE(becomes([&] { return dialog.is_available(Choosing::scene); }, 300ms));
  }
  const DesktopDialog dialog([] {});
  EXPECT_FALSE(becomes([&] { return dialog.is_available(Choosing::scene); }, 100ms));
}

}  // namespace
}  // namespace qs
