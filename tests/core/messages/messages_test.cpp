// SPDX-License-Identifier: BSD-3-Clause
// Encoding of messages: the bytes of each kind, and how receivers treat foreign bytes.
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/neighbor_position.hpp"
#include "tests/support/field_coverage.hpp"

namespace swiftlet {
namespace {

/// Has a field of every type.
struct Everything {
  enum class Mode { kOff, kOn };
  static constexpr const char* kTopic = "everything";
  static constexpr int kVersion = 3;
  static constexpr const char* kDoc = "a field of every type";

  TimeNs t = -5;
  VehicleId vehicle = kNoVehicle;
  bool flag = false;
  int number = 0;
  std::uint16_t small = 0;
  std::uint32_t large = 0;
  float range_m = 0.0F;
  double height_m = 0.0;
  Vector3 p_world_m = Vector3::Zero();
  Pose T_world_body = Pose::Identity();
  Matrix3 covariance = Matrix3::Identity();
  Mode mode = Mode::kOff;
  std::string note;
  std::vector<double> numbers;
  std::vector<StampedPose> poses;

  static void visit(auto& m, auto& v) {
    static constexpr const char* kModes[] = {"off", "on"};
    v.time("t_s", m.t, "[s] when");
    v.vehicle("vehicle", m.vehicle, "[-] a vehicle");
    v.field("flag", m.flag, "[-] a flag");
    v.field("number", m.number, "[-] a number");
    v.field("small", m.small, "[-] a small number");
    v.field("large", m.large, "[-] a large number");
    v.field("range_m", m.range_m, "[m] a range");
    v.field("height_m", m.height_m, "[m] a height");
    v.field("*_m", m.p_world_m, "[m] a position");
    v.field("*", m.T_world_body, "[m, -] a pose");
    v.covariance("cov_*_m2", m.covariance, "[m^2] a covariance");
    v.choice("mode", m.mode, kModes, "[-] a choice");
    v.field("note", m.note, "[-] a text");
    v.field("numbers", m.numbers, "[-] numbers");
    v.list("poses", m.poses, "[m, -] poses");
  }
};

Everything filled() {
  Everything m;
  m.t = 1'234'567'890'123;
  m.vehicle = 7;
  m.flag = true;
  m.number = -42;
  m.small = 65'535;
  m.large = 4'000'000'000U;
  m.range_m = 0.1F;
  m.height_m = -1.0 / 3.0;
  m.p_world_m = {1e-300, -2.5, 1e300};
  m.T_world_body = make_pose({1, 2, 3}, Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3::UnitZ())));
  m.covariance << 4, 1, 2, 1, 5, 3, 2, 3, 6;
  m.mode = Everything::Mode::kOn;
  m.note = "take-off in 5 s";
  m.numbers = {0.1, 0.2};
  m.poses = {{5, Pose::Identity()}};
  return m;
}

TEST(Wire, PreservesEveryFieldType) {
  const Everything sent = filled();
  Message message;
  write_message(sent, message);
  Everything read;
  ASSERT_EQ(read_message(message, read), Reading::kDone);
  EXPECT_EQ(read.t, sent.t);
  EXPECT_EQ(read.vehicle, sent.vehicle);
  EXPECT_EQ(read.flag, sent.flag);
  EXPECT_EQ(read.number, sent.number);
  EXPECT_EQ(read.small, sent.small);
  EXPECT_EQ(read.large, sent.large);
  EXPECT_EQ(read.range_m, sent.range_m);
  EXPECT_EQ(read.height_m, sent.height_m);
  EXPECT_EQ(read.p_world_m, sent.p_world_m);
  EXPECT_TRUE(read.T_world_body.isApprox(sent.T_world_body, 1e-15));
  EXPECT_EQ(read.covariance, sent.covariance);
  EXPECT_EQ(read.mode, sent.mode);
  EXPECT_EQ(read.note, sent.note);
  EXPECT_EQ(read.numbers, sent.numbers);
  ASSERT_EQ(read.poses.size(), 1U);
  EXPECT_EQ(read.poses[0].t, 5);
}

TEST(Wire, NumbersAreLittleEndianWithoutPadding) {
  Message message;
  write_message(NeighborPosition{0x0102030405060708, {1.0, 0.0, -2.0}}, message);
  const std::vector<int> expected = {8, 7, 6, 5, 4, 3, 2, 1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f,
                                     0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,    0xc0};
  std::vector<int> bytes;
  for (const std::byte byte : message.payload) bytes.push_back(std::to_integer<int>(byte));
  EXPECT_EQ(bytes, expected);
}

TEST(Wire, RefusesOtherKindsAndVersions) {
  Message message;
  write_message(NeighborPosition{1, {1, 2, 3}}, message);
  EXPECT_EQ(message.version, NeighborPosition::kVersion);
  NeighborPosition read{9, {7, 7, 7}};
  message.version = NeighborPosition::kVersion + 1;
  EXPECT_EQ(read_message(message, read), Reading::kOtherVersion);
  message.version = NeighborPosition::kVersion;
  message.topic = "weather";
  EXPECT_EQ(read_message(message, read), Reading::kOtherKind);
  EXPECT_EQ(read.t, 9) << "what was there must stay";
}

TEST(Wire, ReadsMessagesOnlyAtExactLength) {
  Message whole;
  write_message(filled(), whole);
  Everything read;
  for (std::size_t size = 0; size < whole.payload.size(); ++size) {
    Message cut = whole;
    cut.payload.resize(size);
    EXPECT_EQ(read_message(cut, read), Reading::kTooShort) << size;
  }
  Message longer = whole;
  longer.payload.push_back(std::byte{0});
  EXPECT_EQ(read_message(longer, read), Reading::kTooLong);
  EXPECT_EQ(read.t, Everything{}.t);
}

TEST(Wire, ReadsOrRefusesArbitraryBytes) {
  std::uint64_t state = 1;  // a congruential sequence: any bytes do
  for (int i = 0; i < 2000; ++i) {
    Message message;
    message.topic = Everything::kTopic;
    message.version = Everything::kVersion;
    for (int n = i % 300; n > 0; --n) {
      state = 6364136223846793005U * state + 1442695040888963407U;
      message.payload.push_back(static_cast<std::byte>(state >> 60));
    }
    Everything read;
    Message again;
    if (read_message(message, read) != Reading::kDone) continue;
    write_message(read, again);
    EXPECT_EQ(again.payload.size(), message.payload.size());
  }
}

TEST(Wire, RefusesInvalidChoicesAndRotations) {
  Everything content = filled();
  content.mode = static_cast<Everything::Mode>(7);
  Message message;
  write_message(content, message);
  Everything read;
  EXPECT_EQ(read_message(message, read), Reading::kBadValue);

  content = filled();
  content.T_world_body.linear().setZero();
  write_message(content, message);
  EXPECT_EQ(read_message(message, read), Reading::kBadValue);
}

TEST(Wire, RefusesNonFiniteNumbers) {
  for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    Message message;
    write_message(NeighborPosition{.t = 1, .p_world_m = {0.0, value, 0.0}}, message);
    NeighborPosition read;
    EXPECT_EQ(read_message(message, read), Reading::kBadValue) << value;
    EXPECT_EQ(read.p_world_m, Vector3(0.0, 0.0, 0.0)) << "nothing of it is kept";
  }
}

TEST(Wire, ReusesTheMemoryOfMessages) {
  Message message;
  write_message(NeighborPosition{}, message);
  const std::byte* const memory = message.payload.data();
  write_message(NeighborPosition{5, {1, 1, 1}}, message);
  EXPECT_EQ(message.payload.data(), memory);
  EXPECT_EQ(message.payload.size(), 32U);
}

/// Counts columns.
class Counter final : public ColumnSink {
 public:
  void time(const ColumnName&, TimeNs) override { ++count; }
  void number(const ColumnName&, double) override { ++count; }
  void integer(const ColumnName&, std::int64_t) override { ++count; }
  void flag(const ColumnName&, bool) override { ++count; }
  void text(const ColumnName&, std::string_view) override { ++count; }
  void vehicle(const ColumnName&, VehicleId) override { ++count; }
  void missing(const ColumnName&) override { ++count; }
  std::size_t count = 0;
};

TEST(MessageKinds, HaveUniqueTopicsAndDescriptions) {
  for (const MessageKind& kind : message_kinds()) {
    EXPECT_EQ(find_message_kind(kind.topic), &kind) << kind.topic;
    EXPECT_GT(std::string(kind.doc).size(), 5U) << kind.topic;
    EXPECT_GT(kind.version, 0) << kind.topic;
    EXPECT_GT(kind.size_bytes(), Message::kHeaderBytes) << kind.topic;
  }
  EXPECT_EQ(find_message_kind("unknown"), nullptr);
}

TEST(MessageKinds, RecordContentSenderAndArrival) {
  Message message;
  message.from = 1;
  write_message(NeighborPosition{5, {1, 2, 3}}, message);
  const MessageKind& kind = *find_message_kind("neighbor");
  Counter row;
  put_message(kind, message, row);
  EXPECT_EQ(row.count, message_columns(kind).size());
  EXPECT_EQ(message_columns(kind).back().name, "received_s");

  message.payload.pop_back();
  EXPECT_EQ(kind.read(message, nullptr), Reading::kTooShort);
  put_message(kind, message, row);
  EXPECT_EQ(row.count, message_columns(kind).size()) << "what cannot be read is not recorded";
}

TEST(NeighborPosition, Takes64BytesOnTheAir) { EXPECT_EQ(find_message_kind("neighbor")->size_bytes(), 64U); }

TEST(NeighborPosition, NamesEveryField) { EXPECT_TRUE(forgets<NeighborPosition>(0)); }

}  // namespace
}  // namespace swiftlet
