// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/detection.hpp"
#include "swiftlet/core/message.hpp"
#include "swiftlet/core/overlay.hpp"
#include "swiftlet/core/relative_estimate.hpp"
#include "swiftlet/core/state_estimate.hpp"
#include "swiftlet/core/track.hpp"

namespace swiftlet {

inline constexpr int kMaxRotors = 8;

/// Where guidance wants the vehicle to be; the reference governor makes it flyable. Local frame between stages, world
/// in Action.
struct Reference {
  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  Vector3 acceleration_mps2 = Vector3::Zero();
  double yaw_rad = 0.0;
  double yaw_rate_radps = 0.0;

  static void visit(auto& r, auto& v) {
    v.field("*_m", r.position_m, "[m] in the world as the vehicle knows it");
    v.field("v*_mps", r.velocity_mps, "[m/s] velocity, in the axes of that world");
    v.field("a*_mps2", r.acceleration_mps2, "[m/s^2] acceleration, in the same axes");
    v.field("yaw_rad", r.yaw_rad, "[rad] heading, counter-clockwise from east");
    v.field("yaw_rate_radps", r.yaw_rate_radps, "[rad/s] rate of the heading");
  }
};

/// What the mission says about itself. Endless: it has no end by design (a hover, a patrol) and all is well.
enum class MissionStatus { kRunning, kEndless, kDone, kFailed };
inline constexpr std::array<const char*, 4> kMissionStatusWords = {"running", "endless", "done", "failed"};

/// Everything that one vehicle does in one tick. Owned by the agent, which reuses it: valid until its next step. All
/// places are told in the world as the vehicle knows it (StateEstimate::T_world_local).
struct Action {
  std::array<double, kMaxRotors>
      rotor_command{};  ///< 0..1 between least and greatest rotor speed, in the airframe's order
  StateEstimate estimate;
  Reference reference;  ///< after the reference governor
  std::vector<Message> messages;
  bool has_detections = false;        ///< the detector finished a scan in this tick, even if it found nothing
  TimeNs detections_stamp = 0;        ///< start of that scan's sweep
  std::vector<Detection> detections;  ///< made in this tick
  bool has_tracks = false;            ///< `tracks` was updated in this tick
  std::vector<Track> tracks;
  std::vector<RelativeEstimate> relatives;  ///< members of the team, as of this tick
  std::vector<Overlay> overlays;
  MissionStatus mission = MissionStatus::kRunning;
  std::string mission_note;  ///< why it failed, or what it waits for; goes to the events when it changes

  /// Overlays are left out: they are made only when somebody looks, and nothing hangs on them.
  static void visit(auto& a, auto& v) {
    v.array("rotor_command", a.rotor_command, "[-] 0 to 1 between least and greatest rotor speed");
    StateEstimate::visit(a.estimate, v);
    Reference::visit(a.reference, v);
    v.list("messages", a.messages, "[-] what the vehicle says");
    v.field("has_detections", a.has_detections, "[-] did the detector finish a scan?");
    v.time("detections_stamp_s", a.detections_stamp, "[s] start of that scan's sweep");
    v.list("detections", a.detections, "[-] what it found");
    v.field("has_tracks", a.has_tracks, "[-] did the tracker take a cloud?");
    v.list("tracks", a.tracks, "[-] what it follows");
    v.list("relatives", a.relatives, "[-] members of the team");
    v.choice("mission", a.mission, std::span<const char* const>(kMissionStatusWords), "[-] how the mission stands");
    v.field("mission_note", a.mission_note, "[-] why it failed, or what it waits for");
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
