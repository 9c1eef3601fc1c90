// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/tracking/track_overlays.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

Track track_at(std::uint32_t id, const Vector3& p_m, const Vector3& v_mps, const Vector3& a_mps2) {
  Track track;
  track.id = id;
  track.position_m = p_m;
  track.velocity_mps = v_mps;
  track.acceleration_mps2 = a_mps2;
  return track;
}

struct Drawn {
  Overlay balls, lines, ellipses;
};

Drawn drawn(const TrackOverlays& pictures, const std::vector<Track>& tracks) {
  std::vector<Overlay> overlays;
  pictures.append(tracks, overlays);
  EXPECT_EQ(overlays.size(), 3U);
  return {overlays.at(0), overlays.at(1), overlays.at(2)};
}

TEST(TrackOverlays, DrawEllipsesAtThreeStandardDeviations) {
  std::vector<Track> tracks = {track_at(1, {10, 20, 30}, {0, 0, 0}, {0, 0, 0})};
  // Axes that are none of the frame's.
  const Matrix3 R = Eigen::AngleAxisd(0.6, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const Matrix3 C = R * Vector3(0.04, 0.09, 0.16).asDiagonal() * R.transpose();
  tracks[0].covariance.setZero();
  tracks[0].covariance.topLeftCorner<3, 3>() = C;
  const Drawn d = drawn({}, tracks);
  ASSERT_EQ(d.ellipses.positions.size(), 3U * 36 * 2);
  Vector3 reach_m = Vector3::Zero();
  for (std::size_t i = 0; i < d.ellipses.positions.size(); ++i) {
    const Vector3 off_m = d.ellipses.positions[i].cast<double>() - tracks[0].position_m;
    EXPECT_NEAR(std::sqrt(off_m.dot(C.inverse() * off_m)), 3.0, 1e-3);
    reach_m = reach_m.cwiseMax((R.transpose() * off_m).cwiseAbs());
    // Around in small steps.
    if (i % 2 == 0) continue;
    EXPECT_LT((d.ellipses.positions[i] - d.ellipses.positions[i - 1]).norm(), 0.22F);
  }
  EXPECT_LT((reach_m - Vector3(0.6, 0.9, 1.2)).norm(), 1e-3);
}

TEST(TrackOverlays, DrawSeparatePathsUntilTracksEnd) {
  TrackOverlays pictures;
  std::vector<Track> tracks = {track_at(1, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}),
                               track_at(2, {0, 50, 0}, {0, 0, 0}, {0, 0, 0})};
  pictures.push(tracks);
  tracks[0].position_m.x() = tracks[1].position_m.x() = 1.0;
  pictures.push(tracks);
  const Drawn both = drawn(pictures, tracks);
  ASSERT_EQ(both.lines.positions.size(), 2U * 8 + 2U * 2);
  EXPECT_EQ(both.lines.positions[17], Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(both.lines.positions[19], Eigen::Vector3f(1, 50, 0));
  EXPECT_NE(both.lines.colors[17], both.lines.colors[19]);
  EXPECT_EQ(both.lines.colors[17], both.balls.colors[0]);
  tracks.erase(tracks.begin());
  pictures.push(tracks);
  EXPECT_EQ(drawn(pictures, tracks).lines.positions.size(), 8U + 2U * 2);
  EXPECT_TRUE(drawn(pictures, {}).balls.positions.empty());
}

}  // namespace
}  // namespace swiftlet
