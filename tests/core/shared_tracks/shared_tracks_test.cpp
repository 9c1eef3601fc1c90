// SPDX-License-Identifier: BSD-3-Clause
// Observers that exchange tracks by radio.
#include "swiftlet/core/shared_tracks/shared_tracks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>

#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/track_report.hpp"
#include "tests/core/shared_tracks/sharing_support.hpp"
#include "tests/support/config_checks.hpp"

namespace swiftlet {
namespace {

/// Reports given tracks.
class GivenTracks : public Tracker {
 public:
  explicit GivenTracks(const std::vector<Track>& tracks) : tracks_(tracks) {}
  bool step(const TrackerInput& input, std::vector<Track>& tracks, Outbox&) override {
    if (!input.has_detections) return false;
    tracks = tracks_;
    return true;
  }

 private:
  const std::vector<Track>& tracks_;
};

struct TeamTrial {
  std::vector<std::vector<int>> sees = {{0, 1}, {1, 2}};  // targets, by observer; all see each other
  double delay_s = 0.05, loss = 0.0;
  double silent_from_s = 1e9;  // all but the first
  bool reverse = false;        // every other message is overtaken by the next
  bool aligned = true;         // they have targets in common
  double existence = 0.9;
  OdometryDriftConfig drift = no_drift();
  SharedTracksConfig config;
};

class SharingTeam {
 public:
  SharingTeam(const TeamTrial& trial, std::uint64_t seed) : trial_(trial), radio_(seed, "test.team", "radio") {
    const std::vector<Flyer> flyers = {observer_a(), observer_b(), observer_c()};
    const char* names[] = {"a", "b", "c"};
    members_.resize(trial.sees.size());
    for (std::size_t i = 0; i < members_.size(); ++i) {
      Member& member = members_[i];
      member.observer = std::make_unique<DriftingObserver>(flyers[i], trial.drift, seed, names[i]);
      AgentSetup setup;
      setup.self = static_cast<VehicleId>(i);
      setup.num_vehicles = static_cast<int>(members_.size());
      member.tracker = make_shared_tracks(trial.config, setup, std::make_unique<GivenTracks>(member.own));
    }
  }

  void fly(double until_s, const std::function<void()>& each = {}) {
    while (t_s() < until_s) {
      for (std::size_t i = 0; i < members_.size(); ++i) step(i);
      if (each) each();
      for (Member& member : members_) member.observer->step();
    }
  }

  double t_s() const { return members_.front().observer->t_s(); }
  const std::vector<Track>& reported(std::size_t i) const { return members_[i].reported; }
  const Tracker& tracker(std::size_t i) const { return *members_[i].tracker; }
  std::vector<RelativeEstimate> relatives(std::size_t i) const {
    std::vector<RelativeEstimate> out;
    members_[i].tracker->append_relatives(members_[i].observer->t(), out);
    return out;
  }
  const DriftingObserver& observer(std::size_t i) const { return *members_[i].observer; }
  /// Tracks of the first one within a distance of a flyer.
  int num_near(const Flyer& flyer, double within_m = 1.0) const {
    const Vector3 p_m = observer(0).to_local(flyer.p_m(t_s()));
    return static_cast<int>(std::count_if(reported(0).begin(), reported(0).end(), [&](const Track& track) {
      return (track.position_m - p_m).norm() < within_m;
    }));
  }
  std::uint64_t counter(const std::string& what) const {
    std::vector<Counter> counters;
    members_[0].tracker->append_counters(counters);
    const auto found = std::find_if(counters.begin(), counters.end(), [&](const Counter& c) { return c.what == what; });
    return found != counters.end() ? found->count : 999;
  }
  std::size_t largest_message = 0;
  std::size_t num_messages = 0;

 private:
  struct Member {
    std::unique_ptr<DriftingObserver> observer;
    std::unique_ptr<Tracker> tracker;
    std::vector<Track> own, reported;
    std::vector<Message> inbox;  // ordered by time of arrival
  };

  void step(std::size_t i) {
    Member& member = members_[i];
    const DriftingObserver& me = *member.observer;
    member.own.clear();
    const std::vector<Flyer> targets = {target_1(), target_2(), target_3()};
    for (const int k : trial_.sees[i]) add(member, targets[static_cast<std::size_t>(k)], 10 + k);
    for (std::size_t j = 0; j < members_.size() && trial_.aligned; ++j) {
      if (j != i) add(member, members_[j].observer->flyer, 20 + static_cast<int>(j));
    }
    Observation observation;
    observation.t = me.t();
    observation.self = static_cast<VehicleId>(i);
    while (!member.inbox.empty() && member.inbox.front().received <= me.t()) {
      observation.messages.push_back(member.inbox.front());
      member.inbox.erase(member.inbox.begin());
    }
    StateEstimate estimate;
    estimate.t = me.t();
    estimate.valid = true;
    estimate.T_local_body = make_pose(me.p_local_m(), Eigen::Quaterniond(me.R()));
    estimate.v_local_mps = me.v_local_mps();
    std::vector<Detection> detections(member.own.size());
    for (Detection& d : detections) d.confidence = trial_.existence;
    TrackerInput input{.observation = observation, .estimate = estimate};
    input.has_detections = true;
    input.detections = detections;
    input.detector_tracks = member.own;
    Outbox outbox(static_cast<VehicleId>(i));
    member.tracker->step(input, member.reported, outbox);
    if (i != 0 && me.t_s() >= trial_.silent_from_s) return;
    for (const Message& message : outbox.messages()) send(message, me.t());
  }

  void add(Member& member, const Flyer& what, int identity) const {
    const MotionEstimate seen = member.observer->seen(what, static_cast<std::uint32_t>(identity), 0.12, 0.4);
    Track track;
    track.id = static_cast<std::uint32_t>(identity);
    track.t = member.observer->t();
    track.position_m = track.measured_m = seen.p_m();
    track.velocity_mps = seen.v_mps();
    track.covariance.topLeftCorner<6, 6>() = seen.covariance;
    track.num_detections = 1;
    track.corrected = true;
    member.own.push_back(track);
  }

  void send(Message message, TimeNs t) {
    largest_message = std::max(largest_message, message.size_bytes());
    ++num_messages;
    message.sent = t;
    // With `reverse`, every other message is so slow that the next one overtakes it.
    const bool slow = trial_.reverse && num_messages_of_[static_cast<std::size_t>(message.from)]++ % 2 == 1;
    message.received = t + from_seconds(trial_.delay_s + (slow ? 0.35 : 0.0));
    for (std::size_t j = 0; j < members_.size(); ++j) {
      if (static_cast<VehicleId>(j) == message.from) continue;
      if (radio_.uniform(count_++, 0) < trial_.loss) continue;
      std::vector<Message>& inbox = members_[j].inbox;
      inbox.insert(std::upper_bound(inbox.begin(), inbox.end(), message,
                                    [](const Message& a, const Message& b) { return a.received < b.received; }),
                   message);
    }
  }

  TeamTrial trial_;
  Random radio_;
  std::vector<Member> members_;
  std::uint32_t count_ = 0;
  std::array<int, 3> num_messages_of_{};
};

TEST(SharedTracks, LocatesTargetsOnlyTheOtherSees) {
  SharingTeam team({}, 1);
  team.fly(20.0);
  int there = 0, scans = 0, observers = 0;
  double error_m = 0.0;
  team.fly(40.0, [&] {
    ++scans;
    there += team.num_near(target_3());
    observers += team.num_near(team.observer(1).flyer);
    EXPECT_EQ(team.num_near(target_1()), 1);
    EXPECT_EQ(team.num_near(target_2()), 1);
    const Vector3 p_m = team.observer(0).to_local(target_3().p_m(team.t_s()));
    double least_m = 1e9;
    for (const Track& track : team.reported(0)) least_m = std::min(least_m, (track.position_m - p_m).norm());
    error_m += least_m;
  });
  EXPECT_EQ(there, scans);
  EXPECT_LT(error_m / scans, 0.45);  // 0.25 s old at most, at 4 m/s^2
  EXPECT_EQ(observers, 0);           // observers are no targets
}

TEST(SharedTracks, WaitsForTheOtherFrame) {
  TeamTrial trial;
  trial.aligned = false;
  trial.sees = {{0}, {2}};
  SharingTeam team(trial, 2);
  team.fly(40.0, [&] { ASSERT_EQ(team.reported(0).size(), 1U); });
  EXPECT_TRUE(team.relatives(0).empty());
}

TEST(SharedTracks, LocatesTheOtherObserver) {
  SharingTeam team({}, 3);
  team.fly(30.0);
  const std::vector<RelativeEstimate> relatives = team.relatives(0);
  ASSERT_EQ(relatives.size(), 1U);
  EXPECT_EQ(relatives[0].other, 1);
  EXPECT_LT((relatives[0].position_m - team.observer(0).to_local(team.observer(1).flyer.p_m(team.t_s()))).norm(), 0.5);
  EXPECT_NEAR(std::remainder(relatives[0].yaw_rad - team.observer(0).yaw_local_world_rad(), 2.0 * kPi), 0.0, 0.02);
}

TEST(SharedTracks, LostAndLateMessagesCostLittle) {
  TeamTrial trial;
  trial.loss = 0.5;
  trial.delay_s = 0.3;
  trial.config.frame.gap_max_s = 1.0;
  SharingTeam team(trial, 4);
  team.fly(25.0);
  int there = 0, scans = 0;
  team.fly(60.0, [&] {
    ++scans;
    there += team.num_near(target_3(), 3.0);
  });
  EXPECT_GT(there, 0.9 * scans);
}

TEST(SharedTracks, IgnoresOvertakenMessages) {
  TeamTrial trial;
  trial.reverse = true;
  SharingTeam team(trial, 5);
  team.fly(25.0);
  EXPECT_GT(team.counter("track messages received after a newer one"), 40U);
  int there = 0, scans = 0;
  team.fly(40.0, [&] {
    ++scans;
    there += team.num_near(target_3(), 2.0);
  });
  EXPECT_GT(there, 0.95 * scans);
}

TEST(SharedTracks, ForgetsAVanishedSender) {
  TeamTrial trial;
  trial.silent_from_s = 25.0;
  SharingTeam team(trial, 6);
  team.fly(25.5);
  EXPECT_EQ(team.num_near(target_3(), 3.0), 1);
  team.fly(27.0);
  EXPECT_EQ(team.num_near(target_3(), 3.0), 0);
  EXPECT_EQ(team.num_near(target_1()), 1);
  EXPECT_TRUE(team.relatives(0).empty());
  EXPECT_EQ(team.num_near(team.observer(1).flyer), 0);  // its body is known by its identity for a while
}

TEST(SharedTracks, ThreeObserversReportEachTargetOnce) {
  TeamTrial trial;
  trial.sees = {{0, 1}, {1, 2}, {0, 1, 2}};
  trial.drift = {};
  SharingTeam team(trial, 7);
  team.fly(25.0);
  int wrong = 0, scans = 0;
  team.fly(60.0, [&] {
    ++scans;
    wrong += team.reported(0).size() != 3;
  });
  EXPECT_LT(wrong, 0.02 * scans);
  EXPECT_EQ(team.relatives(0).size(), 2U);
}

TEST(SharedTracks, ConfirmsWeakTracksSharedByTwo) {
  TeamTrial trial;
  trial.existence = 0.2;
  SharingTeam team(trial, 8);
  team.fly(25.0);
  int common = 0, alone = 0, scans = 0;
  team.fly(35.0, [&] {
    ++scans;
    common += team.num_near(target_2());
    alone += team.num_near(target_1()) + team.num_near(target_3());
  });
  EXPECT_GT(common, 0.95 * scans);
  EXPECT_EQ(alone, 0);
}

TEST(SharedTracks, AMessageIsBounded) {
  TeamTrial trial;
  trial.config.max_sent = 2;
  SharingTeam team(trial, 9);
  team.fly(10.0);
  TrackReport reported;
  reported.tracks.resize(2);
  Message message;
  write_message(reported, message);
  EXPECT_EQ(team.largest_message, message.size_bytes());
  EXPECT_EQ(team.num_messages, 2U * 50U);  // five times a second
  EXPECT_GT(team.counter("tracks left out of a full report"), 0U);
}

TEST(SharedTracks, AnUnsoundMessageChangesNothing) {
  AgentSetup setup;
  std::vector<Track> own;
  const auto tracker = make_shared_tracks(SharedTracksConfig{}, setup, std::make_unique<GivenTracks>(own));
  TrackReport reported;
  reported.t = kNsPerSecond;
  reported.tracks.resize(2);
  reported.tracks[0].covariance(2, 2) = -1.0F;
  reported.tracks[1].existence = 2.0F;
  Observation observation;
  observation.t = 2 * kNsPerSecond;
  observation.messages.resize(3);
  write_message(reported, observation.messages[0]);
  observation.messages[0].from = 1;
  observation.messages[0].received = observation.t;
  observation.messages[1] = observation.messages[0];
  observation.messages[1].payload.pop_back();  // cut
  reported.t = 10 * kNsPerSecond;              // in the future
  write_message(reported, observation.messages[2]);
  observation.messages[2].from = 1;
  observation.messages[2].received = observation.t;
  StateEstimate estimate;
  estimate.t = observation.t;
  estimate.valid = true;
  TrackerInput input{.observation = observation, .estimate = estimate};
  input.has_detections = true;
  Outbox outbox(0);
  std::vector<Track> tracks;
  EXPECT_TRUE(tracker->step(input, tracks, outbox));
  EXPECT_TRUE(tracks.empty());
  std::vector<Counter> counters;
  tracker->append_counters(counters);
  EXPECT_TRUE(std::any_of(counters.begin(), counters.end(), [](const Counter& c) {
    return c.what == "track messages that could not be read" && c.count == 4;
  }));
}

TEST(SharedTracks, RepeatsToTheSameBits) {
  TeamTrial trial;
  trial.sees = {{0, 1}, {1, 2}, {0, 1, 2}};
  trial.drift = {};
  trial.loss = 0.3;
  SharingTeam one(trial, 10), other(trial, 10);
  one.fly(30.0);
  other.fly(30.0);
  ASSERT_EQ(one.reported(0).size(), other.reported(0).size());
  for (std::size_t i = 0; i < one.reported(0).size(); ++i) {
    EXPECT_EQ(one.reported(0)[i].id, other.reported(0)[i].id);
    EXPECT_EQ(one.reported(0)[i].position_m, other.reported(0)[i].position_m);
    EXPECT_EQ(one.reported(0)[i].covariance, other.reported(0)[i].covariance);
  }
}

TEST(SharedTracks, ItsDefaultsAreValid) { EXPECT_TRUE(test::ConfigChecks(SharedTracksConfig{}).problems().empty()); }

}  // namespace
}  // namespace swiftlet
