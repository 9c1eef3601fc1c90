// SPDX-License-Identifier: BSD-3-Clause
// The small parts that the recorders are made of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "sim/recorders/geodesy.hpp"
#include "sim/recorders/md5.hpp"
#include "sim/recorders/ros_encoder.hpp"
#include "sim/recorders/ros_points.hpp"
#include "sim/recorders/ros_rows.hpp"
#include "sim/recorders/ros_types.hpp"
#include "sim/recorders/selection.hpp"
#include "swiftlet/core/base/samples.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/recorders/pose_history.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// As published by the packages of ROS 1.
TEST(RosTypes, HaveTheFingerprintsThatRosKnows) {
  EXPECT_EQ(ros1_fingerprint(kPointCloud2), "1158d486dd51d683ce2f1be655c3c181");
  EXPECT_EQ(ros1_fingerprint(kImu), "6a62c6daae103f4ff57a132d6f95cec2");
  EXPECT_EQ(ros1_fingerprint(kNavSatFix), "2d3a8cd499b9b4a0249fb98fd05cfa48");
  EXPECT_EQ(ros1_fingerprint(kOdometry), "cd5e73d190d741a2f92e81eda573aca7");
  EXPECT_EQ(ros1_fingerprint(kPoseStamped), "d3812c3cbc69362b77dc0b19b345f8f5");
  EXPECT_EQ(ros1_fingerprint(kTFMessage), "94810edda583a504dfda3829e70d7eec");
  EXPECT_EQ(ros1_fingerprint(kClock), "a9c97c1d230cfc112e270351a944ee47");
  EXPECT_EQ(ros1_fingerprint(kMarkerArray), "d155b9ce5188fbaf89745847fd5882d7");
}

TEST(RosTypes, FallBackToRowsOfColumns) {
  const RosType type = row_type("neighbors", columns_of<NeighborSample>());
  EXPECT_EQ(full_name(type, RosDialect::kRos1), "swiftlet_msgs/Neighbors");
  const std::string ros1 = full_definition(type, RosDialect::kRos1), ros2 = full_definition(type, RosDialect::kRos2);
  EXPECT_THAT(ros1, ::testing::StartsWith("std_msgs/Header header\ntime t_s\nstring neighbor\nfloat64 x_body_m\n"));
  EXPECT_THAT(ros1, HasSubstr("MSG: std_msgs/Header\nuint32 seq\n"));
  EXPECT_THAT(ros2, ::testing::StartsWith("std_msgs/Header header\nbuiltin_interfaces/Time t_s\nstring neighbor\n"));
  EXPECT_THAT(ros2, HasSubstr("MSG: builtin_interfaces/Time\nint32 sec\n"));
  EXPECT_EQ(full_name(row_type("id_swaps", {}), RosDialect::kRos2), "swiftlet_msgs/msg/IdSwaps");
  EXPECT_EQ(row_type("az_za_9x_Up_a", {}).name, "AzZa9xUpA");
  EXPECT_EQ(row_type("z_a", {}).name, "ZA");
}

TEST(Md5, IsThatOfTheRfc) {
  EXPECT_EQ(md5(""), "d41d8cd98f00b204e9800998ecf8427e");
  EXPECT_EQ(md5("message digest"), "f96b697d7cb7938d525a2f31aaf161d0");
  EXPECT_EQ(md5("12345678901234567890123456789012345678901234567890123456789012345678901234567890"),
            "57edf4a22be3c955ac49da2e2107b67a");
  // Reference: md5sum, at the ends of blocks and for a length beyond one byte of bits.
  EXPECT_EQ(md5(std::string(55, 'a')), "ef1772b6dff9a122358552954ad0df65");
  EXPECT_EQ(md5(std::string(56, 'a')), "3b0c8ac703f828b04c6c197006d17218");
  EXPECT_EQ(md5(std::string(63, 'a')), "b06521f39153d618550606be297466d5");
  EXPECT_EQ(md5(std::string(64, 'a')), "014842d480b571495a4a0363793f7367");
  EXPECT_EQ(md5(std::string(100'000, 'a')), "1af6d6f2f682f76f80e606aeaaee1680");
  std::string every;
  for (int i = 0; i < 256; ++i) every.push_back(static_cast<char>(i));
  EXPECT_EQ(md5(every), "e2c865db4162bed963bfaa9ef6ac18f0");
}

TEST(RateGate, OpensOncePerPeriod) {
  RateGate gate(25.0);  // every 40 ms, ticks of 15 ms
  std::vector<TimeNs> taken;
  for (TimeNs t = 0; t <= 150'000'000; t += 15'000'000) {
    if (gate.due(t)) taken.push_back(t / 1'000'000);
  }
  EXPECT_THAT(taken, ElementsAre(0, 45, 90, 120));  // the first ticks at or after 0, 40, 80, 120 ms
}

TEST(RateGate, TakesEveryTickAtRateZero) {
  RateGate gate(0.0);
  EXPECT_TRUE(gate.due(0));
  EXPECT_TRUE(gate.due(1));
}

TEST(Selection, DefaultsToAllVehicles) {
  EXPECT_THAT(select_vehicles({}, {"a", "b"}), ElementsAre(true, true));
  EXPECT_THAT(select_vehicles({"b"}, {"a", "b"}), ElementsAre(false, true));
}

TEST(Selection, NamesTheVehiclesThatThereAre) {
  EXPECT_THAT(
      [] {
        select_vehicles({"c"}, {"a", "b"});
      },
      ThrowsMessage<InputError>(::testing::AllOf(HasSubstr("a, b"), HasSubstr("\"c\""))));
}

TEST(PoseHistory, InterpolatesHalfAQuarterTurn) {
  PoseHistory history;
  history.push(0, Pose::Identity());
  history.push(100,
               make_pose({2, 0, 4}, Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitZ()))));
  const Pose middle = history.at(50);
  EXPECT_TRUE(middle.translation().isApprox(Vector3(1, 0, 2)));
  EXPECT_NEAR(yaw_of(middle.linear()), std::numbers::pi / 4, 1e-12);
  EXPECT_TRUE(history.at(-5).isApprox(Pose::Identity()));
  EXPECT_TRUE(history.at(500).translation().isApprox(Vector3(2, 0, 4)));
}

TEST(PoseHistory, TakesOnlyWhatIsNewer) {
  PoseHistory history;
  const auto at_x = [](double x_m) { return make_pose({x_m, 0, 0}, Eigen::Quaterniond::Identity()); };
  history.push(0, at_x(0));
  history.push(100, at_x(10));
  history.push(100, at_x(50));
  history.push(60, at_x(70));
  history.push(200, at_x(20));
  EXPECT_DOUBLE_EQ(history.at(60).translation().x(), 6.0);
  EXPECT_DOUBLE_EQ(history.at(100).translation().x(), 10.0);
  EXPECT_DOUBLE_EQ(history.at(150).translation().x(), 15.0);
  EXPECT_DOUBLE_EQ(history.at(175).translation().x(), 17.5);
}

TEST(PoseHistory, ForgetsPosesOlderThanAnySweep) {
  PoseHistory history;
  for (int second = 0; second <= 10; ++second) {
    history.push(second * kNsPerSecond, make_pose({1.0 * second, 0, 0}, Eigen::Quaterniond::Identity()));
  }
  EXPECT_DOUBLE_EQ(history.at(0).translation().x(), 8.0);
}

std::vector<int> ints(std::span<const std::byte> bytes) {
  std::vector<int> out;
  for (const std::byte b : bytes) out.push_back(std::to_integer<int>(b));
  return out;
}

TEST(RosEncoder, AlignsNumbersOnlyInCdr) {
  // Written by hand: CDR header, text "a" with its zero, padding to 4, a uint16, padding to 8 after the header, a
  // uint64.
  RosEncoder cdr(RosDialect::kRos2);
  cdr.begin();
  cdr.text("a");
  cdr.put(std::uint16_t{0x0102});
  cdr.put(std::uint64_t{3});
  EXPECT_THAT(ints(cdr.bytes()), ElementsAre(0, 1, 0, 0, 2, 0, 0, 0, 'a', 0, 2, 1, 3, 0, 0, 0, 0, 0, 0, 0));
  cdr.put(std::uint8_t{9});
  cdr.put(std::uint32_t{5});
  EXPECT_THAT(ints(cdr.bytes().subspan(20)), ElementsAre(9, 0, 0, 0, 5, 0, 0, 0));

  RosEncoder ros1(RosDialect::kRos1);
  ros1.begin();
  ros1.text("a");
  ros1.put(std::uint16_t{0x0102});
  EXPECT_THAT(ints(ros1.bytes()), ElementsAre(1, 0, 0, 0, 'a', 2, 1));
}

TEST(RosEncoder, SplitsTimesClampingNegativesInRos1) {
  const auto words_of = [](RosDialect dialect, TimeNs t) {
    RosEncoder encoder(dialect);
    encoder.begin();
    encoder.time(t);
    std::pair<std::int32_t, std::uint32_t> words;
    std::memcpy(&words.first, encoder.bytes().data() + encoder.bytes().size() - 8, 4);
    std::memcpy(&words.second, encoder.bytes().data() + encoder.bytes().size() - 4, 4);
    return words;
  };
  for (const RosDialect dialect : {RosDialect::kRos1, RosDialect::kRos2}) {
    EXPECT_EQ(words_of(dialect, 0), std::pair(0, 0U));
    EXPECT_EQ(words_of(dialect, 999'999'999), std::pair(0, 999'999'999U));
    EXPECT_EQ(words_of(dialect, 1'000'000'000), std::pair(1, 0U));
    EXPECT_EQ(words_of(dialect, 7'000'000'001), std::pair(7, 1U));
  }
  EXPECT_EQ(words_of(RosDialect::kRos1, -1), std::pair(0, 0U));
  EXPECT_EQ(words_of(RosDialect::kRos2, -1), std::pair(-1, 999'999'999U));
  EXPECT_EQ(words_of(RosDialect::kRos2, -1'000'000'000), std::pair(-1, 0U));
}

TEST(RosTypes, DefineEverythingTheyMention) {
  const std::string definition = full_definition(kTFMessage, RosDialect::kRos2);
  EXPECT_THAT(definition, HasSubstr("MSG: builtin_interfaces/Time"));
  EXPECT_THAT(definition, ::testing::Not(HasSubstr("uint32 seq")));
  EXPECT_THAT(full_definition(kTFMessage, RosDialect::kRos1), HasSubstr("uint32 seq"));
  EXPECT_EQ(full_name(kImu, RosDialect::kRos1), "sensor_msgs/Imu");
  EXPECT_EQ(full_name(kImu, RosDialect::kRos2), "sensor_msgs/msg/Imu");
}

// WGS 84 in closed form: on the equator, at a pole, and a quarter of the way round.
TEST(Geodesy, IsExactOnTheAxes) {
  constexpr double kEquatorial = 6378137.0, kPolar = 6356752.314245179;
  EXPECT_TRUE(ecef_of({0, 0, 10}).isApprox(Vector3(kEquatorial + 10, 0, 0), 1e-15));
  EXPECT_NEAR((ecef_of({90, 0, 10}) - Vector3(0, 0, kPolar + 10)).norm(), 0.0, 1e-6);
  const Geodetic pole = geodetic_of({0, 0, -kPolar - 5});
  EXPECT_NEAR(pole.latitude_deg, -90.0, 1e-12);
  EXPECT_NEAR(pole.altitude_m, 5.0, 1e-6);
}

TEST(Geodesy, GoesThereAndBack) {
  for (const double latitude : {-89.9, -45.0, 0.0, 12.3, 49.363, 89.0}) {
    for (const double altitude : {-100.0, 0.0, 9000.0}) {
      const Geodetic back = geodetic_of(ecef_of({latitude, 14.261, altitude}));
      EXPECT_NEAR(back.latitude_deg, latitude, 1e-12);
      EXPECT_NEAR(back.longitude_deg, 14.261, 1e-12);
      EXPECT_NEAR(back.altitude_m, altitude, 2e-8);
    }
  }
}

TEST(Geodesy, AppliesEllipsoidCurvatureEastAndNorth) {
  // Radii of curvature at 45 deg (closed form): meridian M = a (1 - e^2) / W^3, prime vertical N = a / W.
  const double e2 = 0.00669437999014132, w = std::sqrt(1 - e2 / 2);
  const double m = 6378137.0 * (1 - e2) / (w * w * w), n = 6378137.0 / w;
  const Geodetic datum{45, 10, 0};
  const double degrees = 180 / std::numbers::pi;
  EXPECT_NEAR(geodetic_of_world({0, 100, 0}, datum).latitude_deg - 45, 100 / m * degrees, 1e-10);
  EXPECT_NEAR(geodetic_of_world({100, 0, 0}, datum).longitude_deg - 10, 100 / (n * std::sqrt(0.5)) * degrees, 1e-10);
  EXPECT_NEAR(geodetic_of_world({0, 0, 30}, datum).altitude_m, 30, 1e-8);
}

// White is at 100 or 150 of 255, brighter returns on a logarithmic scale up to a thousand times white.
TEST(RosPoints, ScaleReflectivityLinearlyThenLogarithmically) {
  const std::tuple<float, int, int> cases[] = {{-1.0F, 100, 0},  {0.0F, 100, 0},         {0.1F, 100, 10},
                                               {1.0F, 100, 100}, {10.0F, 100, 152},      {1000.0F, 150, 255},
                                               {1e9F, 150, 255}, {std::nanf(""), 150, 0}};
  for (const auto& [reflectivity, white, expected] : cases) EXPECT_EQ(reflectivity_byte(reflectivity, white), expected);
}

}  // namespace
}  // namespace swiftlet::sim
