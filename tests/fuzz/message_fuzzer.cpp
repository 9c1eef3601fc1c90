// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of radio messages: the first byte selects the kind, the second the version, the rest is the payload.
// Decoded values must be finite.
#include <cmath>
#include <cstring>

#include "swiftlet/core/messages/kind.hpp"
#include "tests/fuzz/support.hpp"

namespace swiftlet {
namespace {

class FiniteNumbers final : public ColumnSink {
 public:
  void time(const ColumnName&, TimeNs) override {}
  void number(const ColumnName&, double value) override {
    if (!std::isfinite(value)) std::abort();
  }
  void integer(const ColumnName&, std::int64_t) override {}
  void flag(const ColumnName&, bool) override {}
  void text(const ColumnName&, std::string_view) override {}
  void vehicle(const ColumnName&, VehicleId) override {}
  void missing(const ColumnName&) override {}
};

}  // namespace
}  // namespace swiftlet

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  if (size < 2) return 0;
  const MessageKind& kind = message_kinds()[data[0] % message_kinds().size()];
  Message message;
  message.topic = kind.topic;
  message.version = data[1] == 0 ? kind.version : data[1];
  message.payload.resize(size - 2);
  if (size > 2) std::memcpy(message.payload.data(), data + 2, size - 2);
  FiniteNumbers sink;
  (void)kind.read(message, &sink);
  return 0;
}
