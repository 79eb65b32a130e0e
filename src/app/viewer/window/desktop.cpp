// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
#include "app/viewer/window/desktop.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>
#ifdef QUADSPLAT_PORTAL
#include <dbus/dbus.h>
#endif

#include "app/viewer/state/actions.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/bytes/mapped_file.h"

namespace qs {

bool copy_picture(const std::filesystem::path& file) {
  const MappedFile picture(file);
  std::vector<std::string> commands = {"xclip -selection clipboard -t image/png"};
  if (std::getenv("WAYLAND_DISPLAY") != nullptr)
    commands.insert(commands.begin(), "wl-copy --type image/png");
  for (const std::string& command : commands) {
    try {
      ChildProcess program(
          {.words = separated(command, ' '), .socket = {{SOCK_STREAM, STDIN_FILENO}}});
      program.send(picture.content());
      program.close_socket();
      if (program.wait().good()) return true;
    } catch (const Error&) {  // it is not installed
    }
  }
  return false;
}

void DesktopPrograms::open(const std::filesystem::path& path) {
  try {
    started_.emplace_back(path, ChildCommand{.words = {opener_, path.string()}});
  } catch (const Error& error) {
    fail(ErrorKind::device, "{}: cannot be opened: {}", path.string(), error.what());
  }
}

void DesktopPrograms::take_reports(Actions& actions) {
  std::erase_if(started_, [&](Started& started) {
    const auto end = started.process.wait_for(std::chrono::milliseconds(0));
    if (end && !end->good())
      actions.push_back(
          call(action::notify_error, fmt::format("{}: cannot be opened: {} ended with {}",
                                                 started.path.string(), opener_, end->text())));
    return end.has_value();
  });
}

DesktopDialog::DesktopDialog(std::function<void()> wake) : reports_(std::move(wake)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
}

void DesktopDialog::show(const std::filesystem::path& folder, Choosing choosing) {
  const std::lock_guard lock(mutex_);
  if (!wanted_) wanted_ = Wanted{folder, choosing};
  changed_.notify_all();
}

#ifndef QUADSPLAT_PORTAL

void DesktopDialog::serve(const std::stop_token&) {}

#else

namespace {

constexpr std::chrono::seconds kAnswerTime{5};  // a portal that is started answers in this time
constexpr int kTurnMs = 50;                     // between checks of the stop token
constexpr const char* kPortal = "org.freedesktop.portal.Desktop";
constexpr const char* kPortalPath = "/org/freedesktop/portal/desktop";
constexpr const char* kChooser = "org.freedesktop.portal.FileChooser";
constexpr const char* kRequest = "org.freedesktop.portal.Request";

struct Close {
  void operator()(DBusConnection* bus) const {
    dbus_connection_close(bus);
    dbus_connection_unref(bus);
  }
  void operator()(DBusMessage* message) const { dbus_message_unref(message); }
};
using Bus = std::unique_ptr<DBusConnection, Close>;
using Message = std::unique_ptr<DBusMessage, Close>;

// Empty without a session bus.
std::string session_bus() {
  if (const char* address = std::getenv("DBUS_SESSION_BUS_ADDRESS")) return address;
  const char* folder = std::getenv("XDG_RUNTIME_DIR");
  const std::string socket = folder == nullptr ? "" : std::string(folder) + "/bus";
  return is_there(socket) ? "unix:path=" + socket : "";
}

// The session bus. No call waits longer than kTurnMs after a stop was requested, because the window
// may be closed at any time; libdbus's own calls with an answer do not return before it.
class Connection {
 public:
  explicit Connection(std::stop_token stop) : stop_(std::move(stop)) {
    const std::string address = session_bus();
    if (address.empty()) return;
    bus_.reset(dbus_connection_open_private(address.c_str(), nullptr));
    if (!bus_) return;
    dbus_connection_set_exit_on_disconnect(bus_.get(), FALSE);
    const Message hello(dbus_message_new_method_call(DBUS_SERVICE_DBUS, DBUS_PATH_DBUS,
                                                     DBUS_INTERFACE_DBUS, "Hello"));
    const Message reply = answer(hello);
    const char* name = nullptr;
    if (reply && dbus_message_get_args(reply.get(), nullptr, DBUS_TYPE_STRING, &name,
                                       DBUS_TYPE_INVALID) != FALSE)
      is_registered_ = dbus_bus_set_unique_name(bus_.get(), name) != FALSE;
  }

  bool is_registered() const { return is_registered_; }

  // Null if the portal answers with an error or not in time, or a stop was requested.
  Message answer(const Message& call) {
    dbus_uint32_t serial = 0;
    if (dbus_connection_send(bus_.get(), call.get(), &serial) == FALSE) return {};
    Message reply = first(Clock::now() + kAnswerTime, [&](DBusMessage* message) {
      return dbus_message_get_reply_serial(message) == serial;
    });
    const bool good =
        reply && dbus_message_get_type(reply.get()) == DBUS_MESSAGE_TYPE_METHOD_RETURN;
    return good ? std::move(reply) : Message();
  }

  // The response of a request, which a person gives. Null if the connection broke or a stop was
  // requested.
  Message response(const std::string& request) {
    return first(Clock::time_point::max(), [&](DBusMessage* message) {
      return dbus_message_is_signal(message, kRequest, "Response") != FALSE &&
             dbus_message_has_path(message, request.c_str()) != FALSE;
    });
  }

  void send(const Message& message) {
    dbus_connection_send(bus_.get(), message.get(), nullptr);
    dbus_connection_flush(bus_.get());
  }

 private:
  using Clock = std::chrono::steady_clock;

  // The first message that is wanted. Others are kept: a response may come before its answer.
  template <class F>
  Message first(Clock::time_point end, F is_wanted) {
    for (;;) {
      const auto found = std::ranges::find_if(kept_, is_wanted, &Message::get);
      if (found != kept_.end()) {
        Message message = std::move(*found);
        kept_.erase(found);
        return message;
      }
      if (stop_.stop_requested() || Clock::now() >= end) return {};
      if (dbus_connection_read_write(bus_.get(), kTurnMs) == FALSE) return {};
      while (Message message{dbus_connection_pop_message(bus_.get())})
        kept_.push_back(std::move(message));
    }
  }

  std::stop_token stop_;
  Bus bus_;
  std::vector<Message> kept_;
  bool is_registered_ = false;
};

Message call_to(const char* path, const char* interface, const char* method) {
  return Message(dbus_message_new_method_call(kPortal, path, interface, method));
}

// Starts the portal if the bus can. The version of its file chooser; 0: it offers none.
unsigned file_chooser_version(Connection& bus) {
  const char* const property = "version";
  const Message call = call_to(kPortalPath, "org.freedesktop.DBus.Properties", "Get");
  dbus_message_append_args(call.get(), DBUS_TYPE_STRING, &kChooser, DBUS_TYPE_STRING, &property,
                           DBUS_TYPE_INVALID);
  const Message reply = bus.answer(call);
  if (!reply) return 0;
  DBusMessageIter arguments, value;
  dbus_uint32_t version = 1;
  if (dbus_message_iter_init(reply.get(), &arguments) != FALSE &&
      dbus_message_iter_get_arg_type(&arguments) == DBUS_TYPE_VARIANT) {
    dbus_message_iter_recurse(&arguments, &value);
    if (dbus_message_iter_get_arg_type(&value) == DBUS_TYPE_UINT32)
      dbus_message_iter_get_basic(&value, &version);
  }
  return std::max(version, 1u);
}

// {key: value}; fill(value) appends the value, which has this type of D-Bus.
template <class Fill>
void append_option(DBusMessageIter& options, const char* key, const char* type, const Fill& fill) {
  DBusMessageIter entry, value;
  dbus_message_iter_open_container(&options, DBUS_TYPE_DICT_ENTRY, nullptr, &entry);
  dbus_message_iter_append_basic(&entry, DBUS_TYPE_STRING, &key);
  dbus_message_iter_open_container(&entry, DBUS_TYPE_VARIANT, type, &value);
  fill(value);
  dbus_message_iter_close_container(&entry, &value);
  dbus_message_iter_close_container(&options, &entry);
}

// {"current_folder": the bytes of the path with a 0 at their end}, and for a folder "directory".
void append_options(DBusMessageIter& arguments, const std::string& folder, bool is_folder) {
  DBusMessageIter options;
  dbus_message_iter_open_container(&arguments, DBUS_TYPE_ARRAY, "{sv}", &options);
  if (!folder.empty()) {
    append_option(options, "current_folder", "ay", [&](DBusMessageIter& value) {
      const char* const bytes = folder.c_str();
      DBusMessageIter array;
      dbus_message_iter_open_container(&value, DBUS_TYPE_ARRAY, "y", &array);
      dbus_message_iter_append_fixed_array(&array, DBUS_TYPE_BYTE, &bytes,
                                           static_cast<int>(folder.size()) + 1);
      dbus_message_iter_close_container(&value, &array);
    });
  }
  if (is_folder)
    append_option(options, "directory", "b", [](DBusMessageIter& value) {
      const dbus_bool_t is_wanted = TRUE;
      dbus_message_iter_append_basic(&value, DBUS_TYPE_BOOLEAN, &is_wanted);
    });
  dbus_message_iter_close_container(&arguments, &options);
}

// The path of the request object that will send the response; empty after an error.
std::string open_file(Connection& bus, const std::string& folder, bool is_folder) {
  const char *const parent = "", *const title =
                                     is_folder ? "Folder of the photographs" : "Open a scene";
  const Message call = call_to(kPortalPath, kChooser, "OpenFile");
  DBusMessageIter arguments;
  dbus_message_iter_init_append(call.get(), &arguments);
  dbus_message_iter_append_basic(&arguments, DBUS_TYPE_STRING, &parent);
  dbus_message_iter_append_basic(&arguments, DBUS_TYPE_STRING, &title);
  append_options(arguments, folder, is_folder);
  const Message reply = bus.answer(call);
  const char* request = nullptr;
  if (!reply || dbus_message_get_args(reply.get(), nullptr, DBUS_TYPE_OBJECT_PATH, &request,
                                      DBUS_TYPE_INVALID) == FALSE)
    return "";
  return request;
}

// "file:///a%20b" -> "/a b"; empty for other URIs.
std::filesystem::path path_of(std::string_view uri) {
  constexpr std::string_view kFile = "file://";
  if (!uri.starts_with(kFile)) return {};
  uri.remove_prefix(kFile.size());
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool escaped = uri[i] == '%' && i + 2 < uri.size();
    path +=
        escaped
            ? static_cast<char>(std::strtol(std::string(uri.substr(i + 1, 2)).c_str(), nullptr, 16))
            : uri[i];
    if (escaped) i += 2;
  }
  return path;
}

// The first of "uris" in a response (0, {"uris": [...], ...}); empty if the user chose no file.
std::filesystem::path chosen_file(DBusMessage* response) {
  DBusMessageIter arguments, options;
  dbus_uint32_t outcome = 1;
  if (dbus_message_has_signature(response, "ua{sv}") == FALSE) return {};
  dbus_message_iter_init(response, &arguments);
  dbus_message_iter_get_basic(&arguments, &outcome);
  if (outcome != 0) return {};
  dbus_message_iter_next(&arguments);
  dbus_message_iter_recurse(&arguments, &options);
  for (; dbus_message_iter_get_arg_type(&options) == DBUS_TYPE_DICT_ENTRY;
       dbus_message_iter_next(&options)) {
    DBusMessageIter entry, value, list;
    const char *key = nullptr, *uri = nullptr;
    dbus_message_iter_recurse(&options, &entry);
    dbus_message_iter_get_basic(&entry, &key);
    dbus_message_iter_next(&entry);
    dbus_message_iter_recurse(&entry, &value);
    if (std::string_view(key) != "uris" ||
        dbus_message_iter_get_arg_type(&value) != DBUS_TYPE_ARRAY ||
        dbus_message_iter_get_element_type(&value) != DBUS_TYPE_STRING)
      continue;
    dbus_message_iter_recurse(&value, &list);
    if (dbus_message_iter_get_arg_type(&list) != DBUS_TYPE_STRING) return {};
    dbus_message_iter_get_basic(&list, &uri);
    return path_of(uri);
  }
  return {};
}

void close_request(Connection& bus, const std::string& request) {
  if (!request.empty()) bus.send(call_to(request.c_str(), kRequest, "Close"));
}

void show_own_dialog(Viewer& viewer, Choosing choosing) {
  viewer.panels.open = true;
  viewer.choosing = choosing;
}

}  // namespace

void DesktopDialog::serve(const std::stop_token& stop) {
  Connection bus(stop);
  if (!bus.is_registered()) return;
  version_ = file_chooser_version(bus);
  available_ = version_ > 0;
  if (!available_) return;
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return wanted_.has_value(); })) {
    const Wanted wanted = *wanted_;
    lock.unlock();
    const std::string request =
        open_file(bus, wanted.folder.string(), chooses_folder(wanted.choosing));
    Message response;
    if (!request.empty()) response = bus.response(request);
    if (stop.stop_requested()) return close_request(bus, request);
    if (response) {
      const std::filesystem::path file = chosen_file(response.get());
      if (!file.empty()) reports_.report(action::path_chosen, file, wanted.choosing);
    } else {
      available_ = false;
      reports_.report(show_own_dialog, wanted.choosing);
    }
    lock.lock();
    wanted_.reset();
  }
}

#endif

}  // namespace qs
