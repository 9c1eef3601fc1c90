// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Radio message between vehicles. The payload is serialized, so that the radio carries its true size.
struct Message {
  static constexpr const char* kName = "messages";
  VehicleId from = kNoVehicle;
  VehicleId to = kNoVehicle;  ///< kNoVehicle: broadcast
  std::string topic;          ///< short name of the message kind; transmitted with the message
  std::uint16_t version = 0;  ///< version of the message kind (core/messages)
  std::vector<std::byte> payload;
  TimeNs sent = 0;
  TimeNs received = 0;  ///< set by the radio

  static void visit(auto& m, auto& v) {
    v.time("t_s", m.received, "[s] time of reception");
    v.vehicle("sender", m.from, "[-] sender");
    v.vehicle("receiver", m.to, "[-] receiver; empty: broadcast");
    v.time("sent_s", m.sent, "[s] time of sending");
    v.field("topic", m.topic, "[-] message kind");
    v.field("version", m.version, "[-] version of the message kind");
    v.field("payload_bytes", m.payload, "[B] size of the content");
  }

  std::size_t size_bytes() const { return kHeaderBytes + topic.size() + payload.size(); }
  static constexpr std::size_t kHeaderBytes =
      24;  ///< from, to: 4 each; stamp: 8; version, length of the topic: 2 each; length of the payload: 4
};

/// Messages sent by one vehicle in one tick. Every stage of its software may add to it.
class Outbox {
 public:
  explicit Outbox(VehicleId self = kNoVehicle) : self_(self) {}

  /// A new message, to be filled by the caller (core/messages). @param to  kNoVehicle: broadcast
  Message& add(VehicleId to = kNoVehicle) {
    Message& message = messages_.emplace_back();
    if (!spare_.empty()) {
      message.payload = std::move(spare_.back());
      message.payload.clear();
      spare_.pop_back();
    }
    message.from = self_;
    message.to = to;
    return message;
  }
  const std::vector<Message>& messages() const { return messages_; }
  /// Moves the messages out, in exchange for memory to reuse.
  void empty_into(std::vector<Message>& messages) {
    messages.clear();
    messages.swap(messages_);
  }
  /// Takes back messages that are no longer used, to reuse their memory.
  void take_back(std::vector<Message>& messages) {
    for (Message& message : messages) spare_.push_back(std::move(message.payload));
    messages.clear();
  }

 private:
  VehicleId self_;
  std::vector<Message> messages_;
  std::vector<std::vector<std::byte>> spare_;  // payloads
};

}  // namespace swiftlet
