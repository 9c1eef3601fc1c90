// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/sharing/shared_tracks.hpp"
#include "swiftlet/sim/radio/radio.hpp"
#include "swiftlet/sim/run/simulation.hpp"

/// Evaluation of several observers on the same scans, alone and as teams.
namespace swiftlet::tools {

/// Observers that share tracks, and the radio between them.
struct SharingTeam {
  std::string name;
  std::vector<std::size_t> members;  ///< vehicle indices
  sim::RadioConfig radio;
};

/// One target at one scan of one receiver.
struct SharedSighting {
  double t_s = 0.0;
  double receiver = 0.0, target = 0.0;  ///< vehicle indices
  double own_range_m = 0.0;             ///< distance of the target to the receiver
  double nearest_m = 0.0;               ///< distance to the nearest observer with the target in view
  double in_own_view = 0.0;             ///< 1: in the receiver's view
  double found = 0.0;                   ///< 1: a track nearer than 3 m
  double error_m = 0.0;                 ///< position error of that track, in the receiver's own frame
  double track = 0.0;                   ///< identity of that track
};

/// Numbers of tracks that one receiver reports at one scan.
struct SharedScan {
  double t_s = 0.0;
  double receiver = 0.0;
  double told = 0.0, second = 0.0, nobodys = 0.0;  ///< all, duplicates, false ones
  double mates = 0.0;                              ///< tracks of observers of the same team
  double others = 0.0;                             ///< tracks of other observers: neither right nor wrong
};

/// Error of a receiver's estimate of another observer's frame.
struct FrameError {
  double t_s = 0.0;
  double receiver = 0.0, other = 0.0;
  double error_m = 0.0;    ///< position error of the other observer in the receiver's frame
  double yaw_rad = 0.0;    ///< error of its heading there
  double sigma_m = 0.0;    ///< estimated standard deviation, over all axes
  double drifted_m = 0.0;  ///< position error if both frames are assumed fixed since the start
};

/// One team in one flight.
struct TeamRecord {
  std::vector<SharedSighting> sightings;
  std::vector<SharedScan> scans;
  std::vector<FrameError> frames;
  double false_tracks = 0.0;          ///< tracks that are never nearer than 1 m to a vehicle
  double bytes = 0.0, flown_s = 0.0;  ///< sent by all members, and the duration
  double largest_message = 0.0;       ///< [B]
};

/// One flight in which each observer's detector reports tracks (`tracker: {type: detector}`). All teams get the same
/// ones and differ only by what they share.
class SharingLog {
 public:
  /// @param sharing    configuration of every observer
  /// @param ignored_s  start of the flight that is not evaluated: rays must first clear the map
  SharingLog(const sim::Scenario& scenario, std::vector<std::size_t> observers, std::vector<std::size_t> targets,
             std::vector<SharingTeam> teams, const SharedTracksConfig& sharing, double ignored_s);
  ~SharingLog();

  void add(const sim::Simulation& simulation);
  const TeamRecord& of(std::size_t team) const { return records_[team]; }

  /// Results of the flight as numbers, and back: FlightNotes::write and read.
  std::vector<double> numbers();
  void restore(std::span<const double> numbers);

 private:
  struct Team;
  struct Truth {
    TimeNs t = 0;
    std::vector<Vector3> p_m;            // one for each vehicle
    std::vector<Pose> T_estimate_truth;  // for each observer, into the world that it believes in
    std::vector<Vector3> p_sensor_m;     // for each observer
    std::vector<Matrix3> R_world_body;   // for each observer
  };
  const Truth& at(TimeNs t) const;
  bool can_see(std::size_t observer, std::size_t target, const Truth& truth) const;
  void judge(std::size_t team, std::size_t member, TimeNs now);
  void judge_frames(std::size_t team, std::size_t member, const sim::TickView& view);

  std::vector<std::size_t> observers_, targets_;
  sim::World world_;
  TimeNs ignored_;
  std::vector<std::unique_ptr<Team>> teams_;
  std::vector<TeamRecord> records_;
  std::vector<Truth> truth_;  // one each tick
};

}  // namespace swiftlet::tools
