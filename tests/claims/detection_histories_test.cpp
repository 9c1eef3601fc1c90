// SPDX-License-Identifier: BSD-3-Clause
#include "detection_histories.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace swiftlet::tools {
namespace {

Sighting seen(int target, double in_view_s, std::uint32_t track, int points = 1, double range_m = 12.0) {
  Sighting s;
  s.target = target;
  s.visible = in_view_s >= 0.0;
  s.in_view_s = std::max(in_view_s, 0.0);
  s.found = track != 0;
  s.track = track;
  s.points = points;
  s.range_m = range_m;
  return s;
}
constexpr double kHidden = -1.0;

// Two targets alternate, as in a log; each keeps its identity.
TEST(DetectionHistories, AnIdentitySwitchesWhereAnotherGoesOnWithTheSameTarget) {
  std::vector<Sighting> tracks;
  for (int i = 0; i < 10; ++i) {
    tracks.push_back(seen(0, 0.1 * i, 7));
    tracks.push_back(seen(1, 0.1 * i, 8));
  }
  EXPECT_EQ(histories_of(tracks).switches, 0);
  tracks.push_back(seen(0, 1.0, 0));  // lost, then found with a new identity
  tracks.push_back(seen(1, 1.0, 8));
  tracks.push_back(seen(0, 1.1, 9));
  tracks.push_back(seen(1, 1.1, 8));
  EXPECT_EQ(histories_of(tracks).switches, 1);
  tracks.push_back(seen(0, 1.2, 8));  // the targets swap identities: both switch
  tracks.push_back(seen(1, 1.2, 9));
  EXPECT_EQ(histories_of(tracks).switches, 3);
}

TEST(DetectionHistories, EachTargetWaitsForItself) {
  const std::vector<Sighting> tracks = {
      seen(0, 0.0, 0, 1, 20.0), seen(1, kHidden, 0),      // 0 comes into view
      seen(0, 0.1, 0),          seen(1, 0.0, 8, 1, 5.0),  // 1 as well, and is found at once
      seen(0, 0.2, 7),          seen(1, 0.1, 8),          // 0 is found
      seen(0, 0.3, 7),          seen(1, kHidden, 8),      //
      seen(0, 0.4, 7),          seen(1, 0.0, 0, 1, 6.0),  // 1 comes back and leaves before it is found
      seen(0, 0.5, 7),          seen(1, kHidden, 0),      //
      seen(0, 0.6, 7),          seen(1, kHidden, 8)};
  const Histories histories = histories_of(tracks);
  ASSERT_EQ(histories.appearances.size(), 3U);
  EXPECT_EQ(histories.appearances[0].target, 0);
  EXPECT_EQ(histories.appearances[0].range_m, 20.0);
  EXPECT_EQ(histories.appearances[0].until_found_s, 0.2);
  EXPECT_EQ(histories.appearances[1].target, 1);
  EXPECT_EQ(histories.appearances[1].until_found_s, 0.0);
  EXPECT_EQ(histories.appearances[2].range_m, 6.0);
  EXPECT_TRUE(std::isinf(histories.appearances[2].until_found_s));
}

// Target 0 has returns in the first scan only, target 1 in every scan.
TEST(DetectionHistories, TheCeilingOfATargetIsThatOfItsOwnReturns) {
  std::vector<Sighting> sightings;
  for (int i = 0; i < 12; ++i) {
    sightings.push_back(seen(0, 0.1 * i, 0, i == 0 ? 2 : 0));
    sightings.push_back(seen(1, 0.1 * i, 8, 1, i == 0 ? 50.0 : 12.0));
  }
  const std::vector<Judged> judged = judged_sightings(sightings, 40.0);
  ASSERT_EQ(judged.size(), 23U) << "one was too far away";
  using Returned = decltype(Judged::returned);
  EXPECT_EQ(judged[0].returned, (Returned{true, true, true, true}));
  EXPECT_EQ(judged[1].returned, (Returned{false, true, true, true}));
  for (std::size_t i = 2; i < judged.size(); i += 2) {
    EXPECT_EQ(judged[i].returned, (Returned{true, true, true, true}));
    EXPECT_TRUE(judged[i].found);
  }
  const auto of_first = [&](std::size_t scan) { return judged[2 * scan - 1].returned; };
  EXPECT_EQ(of_first(2), (Returned{false, true, true, true}));
  EXPECT_EQ(of_first(3), (Returned{false, false, true, true}));
  EXPECT_EQ(of_first(5), (Returned{false, false, false, true}));
  EXPECT_EQ(of_first(9), (Returned{false, false, false, true}));
  EXPECT_EQ(of_first(10), (Returned{false, false, false, false}));
}

}  // namespace
}  // namespace swiftlet::tools
