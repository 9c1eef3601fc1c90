// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/base/message.hpp"
#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/base/relative_estimate.hpp"
#include "swiftlet/core/base/state_estimate.hpp"
#include "swiftlet/core/base/track.hpp"

namespace swiftlet {

/// [-] Maximum number of rotors of a vehicle; capacity of rotor commands and states.
inline constexpr int kMaxRotors = 8;

/// Pose and motion that guidance commands; the reference governor limits it. Local frame between stages, world in
/// Action.
struct Reference {
  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  Vector3 acceleration_mps2 = Vector3::Zero();
  double yaw_rad = 0.0;
  double yaw_rate_radps = 0.0;

  static void visit(auto& r, auto& v) {
    v.field("*_m", r.position_m, "[m] position in the world frame as estimated by the vehicle");
    v.field("v*_mps", r.velocity_mps, "[m/s] velocity, in the axes of that frame");
    v.field("a*_mps2", r.acceleration_mps2, "[m/s^2] acceleration, in the same axes");
    v.field("yaw_rad", r.yaw_rad, "[rad] heading, counter-clockwise from east");
    v.field("yaw_rate_radps", r.yaw_rate_radps, "[rad/s] rate of the heading");
  }
};

/// Mission state reported by guidance. kEndless: no end by design (hover, patrol); not an error.
enum class MissionStatus { kRunning, kEndless, kDone, kFailed };
inline constexpr std::array<const char*, 4> kMissionStatusWords = {"running", "endless", "done", "failed"};

/// Outputs of one vehicle in one tick. Owned by the agent, which reuses it: valid until its next step. Positions are in
/// the world frame as estimated by the vehicle (StateEstimate::T_world_local).
struct Action {
  std::array<double, kMaxRotors>
      rotor_command{};  ///< 0..1 between least and greatest rotor speed, in the airframe's order
  StateEstimate estimate;
  Reference reference;  ///< output of the reference governor
  std::vector<Message> messages;
  bool has_detections = false;        ///< the detector finished a scan in this tick, even if it found nothing
  TimeNs detections_stamp = 0;        ///< start of that scan's sweep
  std::vector<Detection> detections;  ///< finished in this tick
  bool has_tracks = false;            ///< `tracks` was updated in this tick
  std::vector<Track> tracks;
  std::vector<RelativeEstimate> relatives;  ///< estimates of teammates, as of this tick
  std::vector<Overlay> overlays;
  MissionStatus mission = MissionStatus::kRunning;
  std::string mission_note;  ///< reason of a failure or a wait; recorded as an event when it changes

  /// Overlays are not visited: they are made only for snapshots, and no result depends on them.
  static void visit(auto& a, auto& v) {
    v.array("rotor_command", a.rotor_command, "[-] 0 to 1 between least and greatest rotor speed");
    StateEstimate::visit(a.estimate, v);
    Reference::visit(a.reference, v);
    v.list("messages", a.messages, "[-] messages sent in this tick");
    v.field("has_detections", a.has_detections, "[-] 1: the detector finished a scan in this tick");
    v.time("detections_stamp_s", a.detections_stamp, "[s] start of that scan's sweep");
    v.list("detections", a.detections, "[-] detections of that scan");
    v.field("has_tracks", a.has_tracks, "[-] 1: the tracker processed a cloud in this tick");
    v.list("tracks", a.tracks, "[-] tracks");
    v.list("relatives", a.relatives, "[-] estimates of teammates");
    v.choice("mission", a.mission, std::span<const char* const>(kMissionStatusWords), "[-] mission state");
    v.field("mission_note", a.mission_note, "[-] reason of a failure or a wait");
  }

  void clear_outputs() {
    messages.clear();
    has_detections = false;
    detections.clear();
    has_tracks = false;
    relatives.clear();
    overlays.clear();
  }
};

}  // namespace swiftlet
