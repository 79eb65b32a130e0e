// SPDX-License-Identifier: MIT
#include "app/serve/visitor_link.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "app/serve/requests.h"

namespace qs {
namespace {

constexpr double kTurn = 0.016;  ///< seconds between two pictures, because a screen shows no more
constexpr double kPingTime = 1;  ///< seconds between two pings at least
constexpr double kStateTime = 0.1;  ///< seconds between two states at least
constexpr int kMostInWork = 2;      ///< pictures of a visitor: one is drawn while one is encoded

double seconds_of(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

VisitorLink::VisitorLink(const Room& room, double now) : room_(room), began_(now) {}

double VisitorLink::write_seconds() const { return seconds_of(room_.limits.write_time); }

// ---- events -------------------------------------------------------------------------------------
VisitorLink::Taken VisitorLink::take(std::string_view text, bool is_binary, double now) {
  const auto refuse = [&](CloseCode code, const char* reason) {
    close(code, reason);
    return code == CloseCode::wrong_token ? Taken::wrong_token : Taken::nothing;
  };
  if (closing_) return Taken::nothing;
  if (is_binary) return refuse(CloseCode::binary, "text only");
  if (!is_within_rate(now)) return refuse(CloseCode::too_many, "too many messages");
  const std::optional<ClientMessage> message = parse_message(text);
  if (!message) return refuse(CloseCode::no_json, "not a message of this page");
  const auto* const hello = std::get_if<message::Hello>(&message->body);
  if (!visitor_ && !(hello != nullptr && same_token(room_.token, hello->token)))
    return refuse(CloseCode::wrong_token, "wrong token");
  if (hello != nullptr) {
    if (visitor_) return refuse(CloseCode::too_many, "a second hello");
    visitor_.emplace(room_.scenes, hello->size, now);
    return Taken::hello;
  }
  if (const auto* received = std::get_if<message::Received>(&message->body)) {
    // A new confirmation answers a message of the server, so the flow limits their number.
    if (received->count != flow_.received()) --messages_;
    if (!flow_.received(received->count, received->held / 1000, now))
      return refuse(CloseCode::too_many, "wrong count");
  } else {
    visitor_->take(*message, now);
  }
  return Taken::message;
}

bool VisitorLink::is_within_rate(double now) {
  if (now - second_began_ >= 1) {
    second_began_ = now;
    messages_ = 0;
  }
  return ++messages_ <= room_.limits.messages_per_second;
}

void VisitorLink::written(double now) {
  if (writes_for_ != nullptr) writes_for_->send_ms += 1e3 * (now - writes_since_);
  writes_for_ = nullptr;
  writing_ = false;
  leaves_by_.reset();
}

void VisitorLink::pong(double now) {
  if (pings_) flow_.round_trip(now - pinged_, pinged_alone_);
  pings_ = false;
}

// The next picture may be drawn while this one is encoded, but not sooner than needed for it to be
// encoded next.
void VisitorLink::picture_drawn(double now) {
  renders_ = false;
  next_order_ = std::max(next_order_, now + encoding_seconds_ - rendering_seconds_);
}

void VisitorLink::picture_ready(Picture picture, double now) {
  if (picture.is_last) --in_work_;
  if (!picture.order.lossless) {
    rendering_seconds_ = static_cast<double>(picture.shown.stats.frame_ms) / 1e3;
    encoding_seconds_ = picture.encoded.ms / 1e3;
    making_seconds_ = now - picture.order.ordered;
  }
  if (picture.is_last) visitor_->picture_ready(picture, now);
  const bool is_stale = picture.order.lossless && visitor_->has_moved_on();
  if (!picture.encoded.bytes.empty() && !is_stale) outgoing_.push_back(std::move(picture));
}

void VisitorLink::close(CloseCode code, const char* reason) {
  if (!closing_) closing_ = Close{code, reason};
}

// ---- what is due --------------------------------------------------------------------------------
VisitorLink::Step VisitorLink::advance(double now, const std::function<void(Visitor&)>& pass_on) {
  Step step;
  step.is_dead = leaves_by_ && now >= *leaves_by_;
  if (step.is_dead) return step;
  if (!visitor_ && now >= began_ + seconds_of(room_.limits.token_time))
    close(CloseCode::wrong_token, "no token");
  if (visitor() != nullptr) {
    tick_if_due(now);
    pass_on(*visitor_);
    for (SentFile& file : visitor_->host().take_files()) files_.push_back(std::move(file));
    step.cancels_lossless = visitor_->has_moved_on() && in_work_ > 0;
    if (visitor_->has_moved_on()) drop_lossless();
    step.order = next_order(now);
    step.pings = version_ == 0 && pings_now(now);  // before the state, which takes its time
    if (!writing_) step.message = next_state(now);
    if (!writing_ && !step.message)
      step.message = outgoing_.empty() ? next_file_part(now) : next_part(step, now);
    if (!turn_at_ && visitor_->is_busy()) turn_at_ = now + kTurn;
  }
  if (closing_ && !writing_) step.close = closing_;
  if (step.close || step.message) {
    writing_ = true;
    writes_since_ = now;
    leaves_by_ = now + write_seconds();
  }
  step.wake_at = next_wake();
  return step;
}

void VisitorLink::tick_if_due(double now) {
  const bool is_turn = turn_at_ && now >= *turn_at_;
  if (is_turn) turn_at_.reset();
  if (is_turn || (order_at_ && now >= *order_at_)) visitor_->tick(now);
}

// Moving pictures are all sent, because each refers to the picture before it.
void VisitorLink::drop_lossless() {
  if (!outgoing_.empty() && outgoing_.front().order.lossless) sent_bytes_ = 0;
  std::erase_if(outgoing_, [](const Picture& picture) { return picture.order.lossless; });
}

// While the line has no room, a picture is made so that it is ready when a confirmation makes room.
std::optional<PictureOrder> VisitorLink::next_order(double now) {
  order_at_.reset();
  if (renders_ || in_work_ >= kMostInWork) return {};
  const int coming = in_work_ + static_cast<int>(outgoing_.size());
  double due = next_order_;
  if (!flow_.has_room(coming)) {
    const std::optional<double> room = flow_.next_room(coming);
    if (!room) return {};
    due = std::max(due, *room - making_seconds_);
  }
  if (now < due) {
    order_at_ = due;
    return {};
  }
  next_order_ = now + kTurn;
  std::optional<PictureOrder> order = visitor_->next_order(flow_.speed());
  if (order) {
    order->ordered = now;
    renders_ = true;
    ++in_work_;
  }
  return order;
}

std::optional<VisitorLink::Message> VisitorLink::next_state(double now) {
  checks_state_ = now < next_state_;
  if (checks_state_) return {};
  StateSections sections = state_sections(*visitor_, room_.scenes);
  std::string message = state_message(sections_, sections, version_ + 1);
  next_state_ = now + kStateTime;
  if (message.empty()) return {};
  ++version_;
  sections_ = std::move(sections);
  return Message{std::move(message), true};
}

std::optional<VisitorLink::Message> VisitorLink::next_part(Step& step, double now) {
  const Picture& picture = outgoing_.front();
  const std::size_t end = end_of_part(picture, sent_bytes_);
  const bool is_part = picture.order.lossless;
  if (is_part ? !flow_.has_room_for_part(end - sent_bytes_) : !flow_.has_room()) return {};
  step.pings = step.pings || pings_now(now);
  if (sent_bytes_ == 0 && picture.top == 0) ++picture_;
  writes_for_ = &room_.sent[static_cast<std::size_t>(picture.encoded.codec)];
  if (sent_bytes_ == 0) {
    writes_for_->pictures += picture.top == 0 ? 1 : 0;
    writes_for_->bytes += picture.encoded.bytes.size();
    writes_for_->encode_ms += picture.encoded.ms;
  }
  const auto microseconds = static_cast<std::uint64_t>(1e6 * now);
  Message message{picture_message(picture, {picture_, version_, microseconds}, sent_bytes_)};
  flow_.sent(now, message.bytes.size(), is_part);
  sent_bytes_ = end;
  if (end == picture.encoded.bytes.size()) {
    outgoing_.pop_front();
    sent_bytes_ = 0;
  }
  return message;
}

std::optional<VisitorLink::Message> VisitorLink::next_file_part(double now) {
  if (files_.empty()) return {};
  const SentFile& file = files_.front();
  const std::size_t end = std::min(sent_of_file_ + kFilePart, file.bytes->size());
  if (!flow_.has_room_for_part(end - sent_of_file_)) return {};
  Message message{file_message(file, file_, sent_of_file_)};
  flow_.sent(now, message.bytes.size(), true);
  sent_of_file_ = end;
  if (end == file.bytes->size()) {
    files_.pop_front();
    sent_of_file_ = 0;
    ++file_;
  }
  return message;
}

// The round trip of an empty message is the least one of the line.
bool VisitorLink::pings_now(double now) {
  if (pings_ || writes_ping_ || now < next_ping_) return false;
  pings_ = writes_ping_ = true;
  pinged_ = now;
  next_ping_ = now + kPingTime;
  pinged_alone_ = flow_.is_empty();
  return true;
}

double VisitorLink::next_wake() const {
  double wake = std::numeric_limits<double>::infinity();
  const auto at = [&](std::optional<double> time) { wake = std::min(wake, time.value_or(wake)); };
  at(leaves_by_);
  if (closing_) return wake;
  if (!visitor_) at(began_ + seconds_of(room_.limits.token_time));
  at(turn_at_);
  at(order_at_);
  if (checks_state_ && !writing_) at(next_state_);
  return wake;
}

}  // namespace qs
