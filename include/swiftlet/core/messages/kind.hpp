// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "swiftlet/core/base/fields.hpp"
#include "swiftlet/core/messages/wire.hpp"

/// A kind of message is a struct with `kTopic`, `kVersion`, `kDoc` and a `visit` (swiftlet/core/base/fields.hpp), in a
/// file of its own, with one line in registry.cpp. Encoding, size, reference page, table and topic in recordings are
/// derived from these. Increase kVersion when the fields change: messages with other versions are rejected.
namespace swiftlet {

/// Result of reading a message.
enum class Reading { kDone, kOtherKind, kOtherVersion, kTooShort, kTooLong, kBadValue };

/// Reason of a rejection; empty for kDone.
constexpr const char* reason_of(Reading reading) {
  constexpr const char* kReasons[] = {"",
                                      "the message is of another kind",
                                      "the message has an unknown version",
                                      "the message is shorter than its fields",
                                      "the message is longer than its fields",
                                      "a value is out of range"};
  return kReasons[static_cast<std::size_t>(reading)];
}

/// Sets topic, version and payload; reuses the memory of the message.
template <class Kind>
void write_message(const Kind& content, Message& message) {
  message.topic = Kind::kTopic;
  message.version = Kind::kVersion;
  message.payload.clear();
  Wire wire{WireWriter(message.payload)};
  Kind::visit(content, wire);
}

/// Reads the payload. `content` is unchanged unless the result is kDone.
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

/// Kind of message, as recordings and the reference describe it; all are in core/messages/registry.cpp.
struct MessageKind {
  const char* topic;
  const char* doc;  ///< one line
  int version;
  std::size_t (*size_bytes)();  ///< transmitted bytes with the header, without texts and elements of lists
  std::vector<Column> (*columns)();
  Reading (*read)(const Message& message,
                  ColumnSink* sink);  ///< puts the content into `sink` if it is valid; null: only validates
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
/// Kind with this topic, or null.
const MessageKind* find_message_kind(std::string_view topic);

/// Columns and row of a received message in recordings: content, sender, and time of reception.
std::vector<Column> message_columns(const MessageKind& kind);
void put_message(const MessageKind& kind, const Message& message, ColumnSink& sink);

}  // namespace swiftlet
