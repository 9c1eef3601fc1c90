// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/interception/surroundings.hpp"
#include "swiftlet/core/interception/target_prediction.hpp"
#include "swiftlet/core/message.hpp"
#include "swiftlet/core/messages/chase_report.hpp"
#include "swiftlet/core/observation.hpp"
#include "swiftlet/core/track.hpp"

namespace swiftlet {

inline constexpr double kSameTarget_m = 3.0;  ///< two beliefs of one target are no farther from each other

/// Another interceptor, by its newest report. Local frame.
struct Fellow {
  ChaseReport::Word word = ChaseReport::Word::kIdle;
  TimeNs t = 0;  ///< of the report
  double arrival_s = 0.0;
  PathAhead path;                         ///< from the report's time on
  PointState target;                      ///< at the report's time
  bool same_target = false;               ///< as one's own
  Vector3 off_local_m = Vector3::Zero();  ///< from where it says to be to where it is seen

  Vector3 at(TimeNs now) const { return path.at(to_seconds(now - t)); }
  PointState target_at(TimeNs now) const;
  /// Sees a target and flies after it.
  bool chases() const { return word == ChaseReport::Word::kLeads || word == ChaseReport::Word::kYields; }
  bool has_target() const { return chases() || word == ChaseReport::Word::kSearches; }
};

/// Several interceptors after one target: who can be there first leads, and the others keep out of its way until it
/// has missed. Each decides by what all have told; nobody commands.
class ChaseTeam {
 public:
  ChaseTeam(VehicleId self, int num_vehicles);

  /// Reads what the others tell, and forgets who has been silent.
  void listen(const Observation& observation, const FrameChange& to_local);
  /// Which track is which fellow: the nearest one to where it says to be. @param target  id of one's own; 0: none
  void recognize(std::span<const Track> tracks, std::uint32_t target);
  bool is_fellow(std::uint32_t track) const;
  /// Is somebody else the first after what flies here?
  bool is_led(const Vector3& p_local_m, TimeNs now) const;
  /// Whose target is one's own? @param tolerance_m  between both beliefs
  void compare_targets(const Vector3& target_local_m, TimeNs now, double tolerance_m);

  /// Leads who can be there soonest; who leads already goes on unless another is clearly sooner.
  /// @param arrival_s  own; nothing: it does not chase
  void decide(TimeNs now, std::optional<double> arrival_s);
  bool leads() const { return leads_; }
  bool yields() const { return leader_ != kNoVehicle && leader_ != self_; }
  /// All fellows, to be kept clear of. A leader keeps half of it from those who yield to it, and these plan with more.
  void append_bystanders(TimeNs now, double clearance_m, double yield_clearance_m,
                         std::vector<Bystander>& bystanders) const;
  /// Somebody who chased one's own target has caught it.
  bool has_caught() const;
  /// Somebody who sees a target; null: nobody. Who takes oneself for its target does not count.
  const Fellow* chasing(const Vector3& own_local_m, TimeNs now) const;

  bool is_time_to_tell(TimeNs now) const { return !fellows_.empty() && now >= next_word_; }
  /// @param path  where the vehicle will be, from now on. Local frame, as the target.
  void tell(ChaseReport::Word word, TimeNs now, double arrival_s, const PointState& target, const PathAhead& path,
            const FrameChange& to_world, Outbox& outbox);

 private:
  struct Heard {
    bool fresh = false;
    std::uint32_t track = 0;  // 0: not seen
    Fellow fellow;
  };

  VehicleId self_;
  std::vector<Heard> fellows_;  // by VehicleId; empty: nobody else is there
  VehicleId leader_ = kNoVehicle;
  bool leads_ = true;
  TimeNs next_word_ = 0;
  ChaseReport said_, heard_;  // their memory serves again
};

}  // namespace swiftlet
