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

/// What several observers make of the same scans, alone and together.
namespace swiftlet::tools {

/// Observers who share what they see, and the radio between them.
struct SharingTeam {
  std::string name;
  std::vector<std::size_t> members;  ///< vehicles
  sim::RadioConfig radio;
};

/// One target at one scan of one receiver.
struct SharedSighting {
  double t_s = 0.0;
  double receiver = 0.0, target = 0.0;  ///< vehicles
  double own_range_m = 0.0;             ///< from the receiver
  double nearest_m = 0.0;               ///< from the nearest observer that could see it
  double in_own_view = 0.0;             ///< the receiver could see it itself
  double found = 0.0;                   ///< a track nearer than 3 m
  double error_m = 0.0;                 ///< of that, in the receiver's own frame
  double track = 0.0;                   ///< its identity
};

/// What one receiver told at one scan.
struct SharedScan {
  double t_s = 0.0;
  double receiver = 0.0;
  double told = 0.0, second = 0.0, nobodys = 0.0;
  double mates = 0.0;   ///< observers of the same team that are told as targets
  double others = 0.0;  ///< observers of no team: what flies and is neither right nor wrong
};

/// Where a receiver believed another observer's frame to be.
struct FrameError {
  double t_s = 0.0;
  double receiver = 0.0, other = 0.0;
  double error_m = 0.0;    ///< of the other observer's place in the receiver's frame
  double yaw_rad = 0.0;    ///< and of its heading there
  double sigma_m = 0.0;    ///< as told, over all axes
  double drifted_m = 0.0;  ///< the same error of who takes both frames to be those of the start
};

/// One team in one flight.
struct TeamRecord {
  std::vector<SharedSighting> sightings;
  std::vector<SharedScan> scans;
  std::vector<FrameError> frames;
  double false_tracks = 0.0;          ///< that never were nearer than 1 m to a vehicle
  double bytes = 0.0, flown_s = 0.0;  ///< on the air, of all members, and in what time
  double largest_message = 0.0;       ///< [B]
};

/// One flight in which each observer's own detector tells its tracks (`tracker: {type: detector}`). Every team gets the
/// same ones, so that teams differ by what they share and by nothing else.
class SharingLog {
 public:
  /// @param sharing    of every observer
  /// @param ignored_s  nothing is counted before: the map must first become free
  SharingLog(const sim::Scenario& scenario, std::vector<std::size_t> observers, std::vector<std::size_t> targets,
             std::vector<SharingTeam> teams, const SharedTracksConfig& sharing, double ignored_s);
  ~SharingLog();

  void add(const sim::Simulation& simulation);
  const TeamRecord& of(std::size_t team) const { return records_[team]; }

  /// All that the flight showed, and back again: FlightNotes::write and read.
  std::vector<double> numbers();
  void restore(std::span<const double> numbers);

 private:
  struct Team;
  struct Truth {
    TimeNs t = 0;
    std::vector<Vector3> p_m;            // by vehicle
    std::vector<Pose> T_estimate_truth;  // by observer: to the world that it believes in
    std::vector<Vector3> p_sensor_m;     // by observer
    std::vector<Matrix3> R_world_body;   // by observer
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
  std::vector<Truth> truth_;  // by tick
};

}  // namespace swiftlet::tools
