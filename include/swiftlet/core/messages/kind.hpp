// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "swiftlet/core/fields.hpp"
#include "swiftlet/core/messages/wire.hpp"

/// A kind of message is a struct with `kTopic`, `kVersion`, `kDoc` and a `visit` (swiftlet/core/fields.hpp). It stands
/// in a file of its own, with one line in registry.cpp. Its bytes, its size on the air, its page of the reference, its
/// table and its topic in recordings follow. Change kVersion with the fields: who has other ones does not read what
/// they do not mean.
namespace swiftlet {

/// How reading a message ended.
enum class Reading { kDone, kOtherKind, kOtherVersion, kTooShort, kTooLong, kBadValue };

/// The reason in words; empty when it was read.
constexpr const char* reason_of(Reading reading) {
  constexpr const char* kReasons[] = {"",
                                      "it is of another kind",
                                      "it has another version than this program knows",
                                      "it is shorter than its fields",
                                      "it is longer than its fields",
                                      "a value is out of range"};
  return kReasons[static_cast<std::size_t>(reading)];
}

/// Sets topic, version and payload; the memory of the message is used again.
template <class Kind>
void write_message(const Kind& content, Message& message) {
  message.topic = Kind::kTopic;
  message.version = Kind::kVersion;
  message.payload.clear();
  Wire wire{WireWriter(message.payload)};
  Kind::visit(content, wire);
}

/// `content` is as it was unless the result is kDone.
template <class Kind>
Reading read_message(const Message& message, Kind& content) {
  if (message.topic != Kind::kTopic) return Reading::kOtherKind;
  if (message.version != Kind::kVersion) return Reading::kOtherVersion;
  Kind read{};
  Wire wire{WireReader(message.payload)};
  Kind::visit(read, wire);
  if (wire.stream().short_of_bytes()) return Reading::kTooShort;
  if (wire.stream().num_left() > 0) return Reading::kTooLong;
  if (wire.has_bad_value()) return Reading::kBadValue;
  content = std::move(read);
  return Reading::kDone;
}

/// One row of registry.cpp: what recordings and the reference need to know of a kind.
struct MessageKind {
  const char* topic;
  const char* doc;  ///< one line
  int version;
  std::size_t (*size_bytes)();  ///< on the air, with its header; without texts and elements of lists
  std::vector<Column> (*columns)();
  Reading (*read)(const Message& message,
                  ColumnSink* sink);  ///< puts its content when it can be read; null: only tries
};

template <class Kind>
constexpr MessageKind message_kind() {
  return {Kind::kTopic,
          Kind::kDoc,
          Kind::kVersion,
          [] {
            Message message;
            write_message(Kind{}, message);
            return message.size_bytes();
          },
          columns_of<Kind>,
          [](const Message& message, ColumnSink* sink) {
            Kind content;
            const Reading reading = read_message(message, content);
            if (reading == Reading::kDone && sink != nullptr) put_columns(content, *sink);
            return reading;
          }};
}

std::span<const MessageKind> message_kinds();
/// The kind of that topic, or null.
const MessageKind* find_message_kind(std::string_view topic);

/// How a received message is recorded: what it says, who sent it, and when it came.
std::vector<Column> message_columns(const MessageKind& kind);
void put_message(const MessageKind& kind, const Message& message, ColumnSink& sink);

}  // namespace swiftlet
