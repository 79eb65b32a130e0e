// SPDX-License-Identifier: MIT
#include "app/serve/connections.h"

#include <algorithm>
#include <utility>

namespace qs {
namespace {

constexpr std::chrono::minutes kMemory{1};             ///< for wrong tokens
constexpr ConnectionLimit ServeLimits::*kLimits[] = {  // index = ConnectionKind
    &ServeLimits::requests, &ServeLimits::visitors, &ServeLimits::leaving};

std::size_t index_of(ConnectionKind kind) { return static_cast<std::size_t>(kind); }

}  // namespace

Connections::Place::Place(Connections& all, std::string address, ConnectionKind kind)
    : all_(all), address_(std::move(address)), kind_(kind) {
  all_.count(address_, kind_, 1);
}

Connections::Place::~Place() { all_.count(address_, kind_, -1); }

bool Connections::Place::move_to(ConnectionKind kind) {
  if (kind == kind_) return true;
  if (!all_.has_room(address_, kind)) return false;
  all_.count(address_, kind, 1);
  all_.count(address_, std::exchange(kind_, kind), -1);
  return true;
}

std::unique_ptr<Connections::Place> Connections::enter(const std::string& address) {
  for (const ConnectionKind kind : {ConnectionKind::request, ConnectionKind::leaving})
    if (has_room(address, kind)) return std::unique_ptr<Place>(new Place(*this, address, kind));
  return nullptr;
}

void Connections::note_wrong_token(const std::string& address, Time now) {
  addresses_[address].wrong_tokens.push_back(now);
}

bool Connections::has_too_many_wrong_tokens(const std::string& address, Time now) {
  const auto found = addresses_.find(address);
  if (found == addresses_.end()) return false;
  forget_old(found->second, now);
  return std::ssize(found->second.wrong_tokens) >= limits_.wrong_tokens_per_minute;
}

void Connections::prune(Time now) {
  for (auto& entry : addresses_) forget_old(entry.second, now);
  std::erase_if(addresses_, [](const auto& entry) {
    return entry.second.wrong_tokens.empty() && entry.second.connections == Counts{};
  });
}

bool Connections::has_room(const std::string& address, ConnectionKind kind) const {
  const ConnectionLimit& limit = limits_.*kLimits[index_of(kind)];
  const auto found = addresses_.find(address);
  const int here = found == addresses_.end() ? 0 : found->second.connections[index_of(kind)];
  return counts_[index_of(kind)] < limit.all && here < limit.per_address;
}

void Connections::count(const std::string& address, ConnectionKind kind, int change) {
  addresses_[address].connections[index_of(kind)] += change;
  counts_[index_of(kind)] += change;
}

void Connections::forget_old(Address& address, Time now) {
  std::erase_if(address.wrong_tokens, [&](Time time) { return now - time > kMemory; });
}

}  // namespace qs
