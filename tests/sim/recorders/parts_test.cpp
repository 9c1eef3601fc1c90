// SPDX-License-Identifier: BSD-3-Clause
// The small parts that the recorders are made of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>

#include "sim/recorders/geodesy.hpp"
#include "sim/recorders/md5.hpp"
#include "sim/recorders/ros_encoder.hpp"
#include "sim/recorders/ros_markers.hpp"
#include "sim/recorders/ros_points.hpp"
#include "sim/recorders/ros_rows.hpp"
#include "sim/recorders/ros_types.hpp"
#include "sim/recorders/selection.hpp"
#include "swiftlet/core/samples.hpp"
#include "swiftlet/sim/errors.hpp"
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

TEST(RosEncoder, CountsNanosecondsUpwardsBeforeZero) {
  RosEncoder cdr(RosDialect::kRos2);
  cdr.begin();
  cdr.time(-250'000'000);
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  std::memcpy(&seconds, cdr.bytes().data() + 4, 4);
  std::memcpy(&nanoseconds, cdr.bytes().data() + 8, 4);
  EXPECT_EQ(seconds, -1);
  EXPECT_EQ(nanoseconds, 750'000'000U);
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

TEST(RosPoints, MeasureOusterRangesFromTheAxis) {
  // Two beams that start 27.67 mm off the axis, 10 m long; one of them without return.
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = 2;
  beams->directions_lidar.assign(2, Eigen::Vector3f::UnitX());
  beams->origins_lidar.assign(2, Eigen::Vector3f(0.0F, 0.02767F, 0.0F));
  beams->column_offset_s = {0.0F, 0.05F};
  Scan scan;
  scan.beams = beams;
  scan.range_m = {10.0F, 0.0F};
  scan.intensity = scan.reflectivity = {0.5F, 0.0F};
  RosEncoder out(RosDialect::kRos1);
  encode_points(scan, PointsLayout::kOuster, 0.0F, 0, "lidar", out);
  const auto points = out.bytes().last(2 * 48 + 1);  // and a byte for is_dense
  const auto uint32_at = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, points.data() + at, sizeof value);
    return value;
  };
  EXPECT_EQ(uint32_at(32), 10028U);
  EXPECT_EQ(uint32_at(48 + 32), 0U) << "an empty return stays empty";
}

/// The last bytes of a message as numbers.
template <class Number>
Number number_at(std::span<const std::byte> bytes, std::size_t at) {
  Number value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

TEST(RosPoints, SmallLayoutHoldsOnlyRoundedReturns) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = 3;
  beams->directions_lidar = {Eigen::Vector3f::UnitX(), Eigen::Vector3f::UnitY(), Eigen::Vector3f(0.6F, 0.0F, 0.8F)};
  beams->origins_lidar.assign(3, Eigen::Vector3f::Zero());
  beams->column_offset_s = {0.0F, 0.01F, 0.02F};
  Scan scan;
  scan.beams = beams;
  scan.range_m = {10.0012F, 0.0F, 5.0F};
  scan.intensity = scan.reflectivity = {0.5F, 0.0F, 1.0F};
  const auto points_of = [&](float step_m) {
    RosEncoder out(RosDialect::kRos1);
    encode_points(scan, PointsLayout::kSmall, step_m, 0, "lidar", out);
    const auto bytes = out.bytes();
    EXPECT_EQ(number_at<std::uint32_t>(bytes, bytes.size() - 2 * 16 - 1 - 4), 2U * 16U) << "two of three returned";
    return std::vector<std::byte>(bytes.end() - 2 * 16 - 1, bytes.end());
  };
  const auto exact = points_of(0.0F), rounded = points_of(0.25F);
  EXPECT_FLOAT_EQ(number_at<float>(exact, 0), 10.0012F);
  EXPECT_FLOAT_EQ(number_at<float>(rounded, 0), 10.0F);
  EXPECT_FLOAT_EQ(number_at<float>(exact, 12), 50.0F) << "half of white";
  EXPECT_FLOAT_EQ(number_at<float>(rounded, 16), 3.0F);
  EXPECT_FLOAT_EQ(number_at<float>(rounded, 24), 4.0F);
}

// Offsets of the fields as the makers' drivers publish them.
TEST(RosPoints, VendorLayoutsHoldRowsAndTimes) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 2;
  beams->cols = 3;
  for (int i = 0; i < 6; ++i)
    beams->directions_lidar.push_back(Eigen::Vector3f(1.0F, 0.1F * static_cast<float>(i), 0.2F).normalized());
  beams->origins_lidar.assign(6, Eigen::Vector3f::Zero());
  beams->column_offset_s = {0.0F, 0.01F, 0.02F};
  Scan scan;
  scan.beams = beams;
  scan.duration = 30'000'000;
  scan.range_m = {1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F};
  scan.intensity = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};
  scan.reflectivity.assign(6, 0.5F);
  constexpr std::size_t kOuster = 48, kLivox = 26;
  RosEncoder ouster(RosDialect::kRos1), livox(RosDialect::kRos1);
  encode_points(scan, PointsLayout::kOuster, 0.0F, 0, "lidar", ouster);
  encode_points(scan, PointsLayout::kLivox, 0.0F, 0, "lidar", livox);
  const auto of_ouster = ouster.bytes().last(6 * kOuster + 1), of_livox = livox.bytes().last(6 * kLivox + 1);
  std::vector<int> lines;
  for (int i = 0; i < 6; ++i) {
    const auto point = of_ouster.subspan(static_cast<std::size_t>(i) * kOuster);
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_EQ(number_at<float>(point, 4 * axis), scan.point_lidar(i)[static_cast<Eigen::Index>(axis)]);
    EXPECT_EQ(number_at<float>(point, 16), scan.intensity[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(number_at<std::uint32_t>(point, 20), i % 3 * 10'000'000.0, 1.0);
    EXPECT_EQ(number_at<std::uint16_t>(point, 26), i / 3);
    EXPECT_EQ(number_at<std::uint32_t>(point, 32), 1000U * static_cast<std::uint32_t>(i + 1));
    // The other maker's points come in order of time.
    const auto shot = of_livox.subspan(static_cast<std::size_t>(i) * kLivox);
    const auto line = static_cast<int>(number_at<std::uint8_t>(shot, 17));
    const int beam = line * 3 + i / 2;
    ASSERT_LT(beam, 6);
    lines.push_back(line);
    EXPECT_EQ(number_at<float>(shot, 0), scan.point_lidar(beam).x());
    EXPECT_EQ(number_at<std::uint8_t>(shot, 16), 0);  // tag: a certain return
    EXPECT_NEAR(number_at<double>(shot, 18), i / 2 * 1e7, 1.0);
  }
  EXPECT_EQ(std::count(lines.begin(), lines.end(), 1), 3);
}

TEST(RosMarkers, GroupWorldTrianglesByMaterial) {
  Scene scene;
  scene.materials = {{.name = "nothing"}, {.name = "wall", .color_rgb = {0.25F, 0.5F, 0.75F}}};
  Mesh mesh;
  mesh.vertices_mesh_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.material = 1;
  scene.meshes = {mesh};
  for (const float x_m : {0.0F, 10.0F}) {
    Instance instance;
    instance.T_world_mesh = Eigen::Affine3f(Eigen::Translation3f(x_m, 0.0F, 2.0F));
    scene.instances.push_back(instance);
  }
  RosEncoder out(RosDialect::kRos1);
  encode_world_markers(scene, 0, 0, out);
  const auto bytes = out.bytes();
  EXPECT_EQ(number_at<std::uint32_t>(bytes, 0), 1U) << "the material of nothing has no marker";
  const std::size_t type = 4 + 4 + 8 + (4 + 5) + (4 + 5) + 4;  // count, header with "world", space "world", id
  EXPECT_EQ(number_at<std::int32_t>(bytes, type), 11);         // TRIANGLE_LIST
  const std::size_t color = type + 4 + 4 + 7 * 8 + 3 * 8;      // after action, pose, scale
  EXPECT_EQ(number_at<double>(bytes, color - 8), 1.0) << "in meters";
  EXPECT_EQ(number_at<float>(bytes, color + 4), 0.5F);
  EXPECT_EQ(number_at<float>(bytes, color + 12), 1.0F);
  const std::size_t points = color + 4 * 4 + 8 + 1;  // after lifetime and frame_locked
  ASSERT_EQ(number_at<std::uint32_t>(bytes, points), 6U);
  EXPECT_EQ(number_at<double>(bytes, points + 4 + 16), 2.0);
  EXPECT_EQ(number_at<double>(bytes, points + 4 + 4 * 24), 11.0) << "the second corner of the second one";
}

TEST(RosMarkers, FollowVehicleFramesWithRotorDiscs) {
  VehicleShape shape;
  shape.materials = {{.name = "frame"}};
  VehicleShape::RotorShape rotor;
  rotor.hub_body_m = {0.2F, 0.0F, 0.1F};
  rotor.radius_m = 0.15F;
  shape.rotors = {rotor};
  RosEncoder out(RosDialect::kRos1);
  encode_vehicle_markers(shape, "uav1/body", 0, 0, out);
  const auto bytes = out.bytes();
  const std::size_t locked = 4 + 4 + 8 + (4 + 9) + (4 + 5) + 12 + 7 * 8 + 3 * 8 + 4 * 4 + 8;
  EXPECT_EQ(number_at<std::uint8_t>(bytes, locked), 1);
  const auto count = number_at<std::uint32_t>(bytes, locked + 1);
  EXPECT_EQ(count % 6, 0U);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t at = locked + 5 + 24 * i;
    const double x_m = number_at<double>(bytes, at) - 0.2F, y_m = number_at<double>(bytes, at + 8);
    EXPECT_NEAR(std::hypot(x_m, y_m), i % 3 == 0 ? 0.0 : 0.15, 1e-6);
    EXPECT_EQ(number_at<double>(bytes, at + 16), static_cast<double>(0.1F));
  }
}

TEST(RosPoints, ScaleReflectivityLinearlyThenLogarithmically) {
  for (const int white : {100, 150}) {
    for (float reflectivity = 1e-3F; reflectivity < 1e4F; reflectivity *= 1.0137F) {
      const double beyond = std::min(std::log10(static_cast<double>(reflectivity)) / 3.0, 1.0);
      const double expected =
          reflectivity <= 1.0F ? white * static_cast<double>(reflectivity) : white + (255.0 - white) * beyond;
      EXPECT_NEAR(reflectivity_byte(reflectivity, white), expected, 0.501) << reflectivity;
    }
  }
  EXPECT_EQ(reflectivity_byte(-1.0F, 100), 0);
  EXPECT_EQ(reflectivity_byte(0.0F, 100), 0);
  EXPECT_EQ(reflectivity_byte(0.1F, 100), 10);
  EXPECT_EQ(reflectivity_byte(1.0F, 100), 100);
  EXPECT_EQ(reflectivity_byte(10.0F, 100), 152);  // a third of the way from 100 to 255
  EXPECT_EQ(reflectivity_byte(1000.0F, 150), 255);
  EXPECT_EQ(reflectivity_byte(1e9F, 150), 255);
  EXPECT_EQ(reflectivity_byte(std::nanf(""), 150), 0);
}

}  // namespace
}  // namespace swiftlet::sim
