// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/agent/stack.hpp"

#include <functional>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "core/agent/look_around.hpp"
#include "core/agent/trail.hpp"
#include "core/agent/way_back.hpp"
#include "swiftlet/core/agent/localization_status.hpp"
#include "swiftlet/core/agent/stage_notifier.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/core/control/controller.hpp"
#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/slam/joined_map.hpp"
#include "swiftlet/core/slam/saved_map.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "swiftlet/core/stage_tables/trackers.hpp"
#include "swiftlet/core/tracking/track_overlays.hpp"

namespace swiftlet {
namespace {

/// A reference with the vehicle's present pose and velocity.
Reference at_rest_with(const StateEstimate& estimate) {
  Reference reference;
  reference.position_m = estimate.T_local_body.translation();
  reference.velocity_mps = estimate.v_local_mps;
  reference.yaw_rad = yaw_of(estimate.T_local_body.linear());
  return reference;
}

/// Throws std::invalid_argument when a stage lacks another one that it needs.
void require_complete(const StackStages& stages, const GuidanceNeeds& needs) {
  if (needs.map && stages.mapping == nullptr)
    throw std::invalid_argument("mapping: expected a type other than none, because guidance needs a map");
  if (stages.mapping != nullptr && stages.mapping->needs_submaps() && stages.localization->submap_poses() == nullptr) {
    throw std::invalid_argument(
        "localization: expected {type: slam, global: {enabled: true}}, because mapping uses the submaps of its pose "
        "graph");
  }
  if (needs.relatives && stages.relative_localization == nullptr) {
    throw std::invalid_argument(
        "relative_localization: expected a type other than none, because guidance needs the pose of another vehicle");
  }
}

/// All stages work in the local frame; outputs (`action_`) are in the world.
class StackAgent : public Agent,
                   public SavedMapProvider,
                   public JoinedMapProvider,
                   public LocalizationReporter,
                   public StageNotifier {
 public:
  StackAgent(StackStages stages, const ControlConfig& control, const AgentSetup& setup)
      : self_(setup.self),
        tick_s_(setup.tick_s),
        stages_(std::move(stages)),
        needs_(stages_.guidance->needs()),
        registrar_(setup.airframe.circumscribed_radius_m()),
        reference_governor_(control.limits.resolve()),
        controller_(setup.airframe, control.gains, setup.tick_s),
        joined_map_provider_(dynamic_cast<const JoinedMapProvider*>(stages_.localization.get())),
        outbox_(setup.self) {
    require_complete(stages_, needs_);
  }

  const Action& step(const Observation& observation) override {
    ENSURE(observation.self == self_, observation.self, self_);
    const double dt_s = started_ ? to_seconds(observation.t - last_t_) : tick_s_;
    if (started_ && dt_s <= 0.0) return action_;  // no time has passed
    last_t_ = observation.t;
    started_ = true;
    outbox_.take_back(action_.messages);
    action_.clear_outputs();

    begin(AgentStage::kLocalization);
    action_.estimate = stages_.localization->update(observation, outbox_);
    if (action_.estimate.valid) {
      ENSURE(is_finite(action_.estimate), action_.estimate.T_local_body.translation(), action_.estimate.v_local_mps,
             action_.estimate.omega_body_radps);
      to_world_ = FrameChange::to_world(action_.estimate);
      place_scans(observation);
      detect(observation);
      track(observation);
      find_team(observation);
      report_known_vehicles();
      map(observation);
      guide(observation, dt_s);
      fly(dt_s);
      begin(AgentStage::kOther);
      if (observation.wants_overlays) append_overlays();
    } else {
      give_up(dt_s);
    }
    outbox_.empty_into(action_.messages);
    return action_;
  }

  void set_stage_listener(std::function<void(AgentStage)> begins) override { begins_ = std::move(begins); }

  LocalizationStatus localization_status() const override {
    return {stages_.localization->fault(), stages_.localization->warning()};
  }

  void append_counters(std::vector<Counter>& counters) const override {
    const auto append = [&](const auto& stage, const char* key) {
      const std::size_t first = counters.size();
      if (stage != nullptr) stage->append_counters(counters);
      for (std::size_t i = first; i < counters.size(); ++i) counters[i].setting.insert(0, key);
    };
    append(stages_.localization, "localization.");
    append(stages_.detector, "detector.");
    append(stages_.tracker, "tracker.");
    append(stages_.relative_localization, "relative_localization.");
    append(stages_.mapping, "mapping.");
    append(stages_.guidance, "guidance.");
  }

  void append_maps(std::vector<MapVoxels>& maps) const override {
    const auto append = [&](const auto& map, const char* stage) {
      maps.emplace_back().name = stage;
      map.append_voxels(maps.back());
    };
    if (stages_.detector && stages_.detector->map() != nullptr) append(*stages_.detector->map(), "detector");
    if (stages_.mapping) append(stages_.mapping->map(), "mapping");
    if (const auto saved = saved_map()) {
      maps.emplace_back().name = "localization";
      append_voxels(*saved, action_.estimate.T_world_local.inverse(), maps.back());
    }
  }

  std::shared_ptr<const SavedMap> saved_map() const override {
    const auto* provider = dynamic_cast<const SavedMapProvider*>(stages_.localization.get());
    std::shared_ptr<const SavedMap> saved = provider != nullptr ? provider->saved_map() : nullptr;
    const SubmapPoses* poses = stages_.localization->submap_poses();
    if (saved == nullptr || poses == nullptr || stages_.mapping == nullptr) return saved;
    std::vector<MapPiece> pieces;
    stages_.mapping->append_pieces(pieces);
    return with_pieces(std::move(saved), *poses, pieces);
  }

  std::span<const JoinedMap> joined_maps() const override {
    return joined_map_provider_ != nullptr ? joined_map_provider_->joined_maps() : std::span<const JoinedMap>();
  }

 private:
  void begin(AgentStage stage) {
    if (begins_) begins_(stage);
  }

  /// Converts scans to clouds in the local frame, once for all stages.
  void place_scans(const Observation& observation) {
    begin(AgentStage::kClouds);
    registrar_.push(action_.estimate);
    clouds_.clear();
    const bool relative = stages_.relative_localization && stages_.relative_localization->needs_clouds();
    if (!stages_.detector && !stages_.tracker && !stages_.mapping && !relative && !needs_.clouds) return;
    for (const auto& scan : observation.scans) {
      if (auto cloud = cloud_pool_.make(scan, registrar_)) clouds_.push_back(std::move(cloud));
    }
  }

  void detect(const Observation& observation) {
    if (!stages_.detector) return;
    begin(AgentStage::kDetection);
    found_.clear();
    stages_.detector->step({observation.t, action_.estimate, registrar_.poses(), clouds_, observation}, found_,
                           outbox_);
    action_.has_detections = found_.has_detections;
    action_.detections_stamp = found_.stamp;
    for (const Detection& d : found_.detections) action_.detections.push_back(to_world_.detection(d));
    for (const Detection& d : action_.detections) ENSURE(is_finite(d), d.position_m, d.extent_m, d.confidence);
  }

  void track(const Observation& observation) {
    if (!stages_.tracker) return;
    begin(AgentStage::kTracking);
    TrackerInput input{.observation = observation, .estimate = action_.estimate, .clouds = clouds_};
    input.has_detections = found_.has_detections;
    input.detections = found_.detections;
    if (stages_.detector) {
      input.detector_tracks = stages_.detector->tracks();
      input.background = stages_.detector->map();
    }
    action_.has_tracks = stages_.tracker->step(input, tracks_, outbox_);
    if (!action_.has_tracks) return;
    if (needs_.track_modes) stages_.tracker->modes(track_modes_);
    track_overlays_.push(tracks_);
    action_.tracks.clear();
    for (const Track& t : tracks_) ENSURE(is_finite(t), t.id, t.position_m, t.velocity_mps);
    for (const Track& t : tracks_) action_.tracks.push_back(to_world_.track(t));
  }

  void find_team(const Observation& observation) {
    relatives_.clear();
    if (stages_.relative_localization) {
      begin(AgentStage::kRelativeLocalization);
      stages_.relative_localization->step({.observation = observation,
                                           .estimate = action_.estimate,
                                           .poses = registrar_.poses(),
                                           .detections = found_.detections,
                                           .has_tracks = action_.has_tracks,
                                           .tracks = tracks_,
                                           .clouds = clouds_},
                                          relatives_, outbox_);
    } else if (stages_.tracker) {
      stages_.tracker->append_relatives(observation.t, relatives_);
    }
    for (const RelativeEstimate& r : relatives_) ENSURE(is_finite(r), r.other, r.position_m, r.velocity_mps, r.yaw_rad);
    for (const RelativeEstimate& r : relatives_) action_.relatives.push_back(to_world_.relative(r));
  }

  /// Reports known vehicles to localization, which ignores them in the next scans.
  void report_known_vehicles() {
    if (!stages_.tracker && !stages_.relative_localization) return;
    seen_.clear();
    for (const Track& t : tracks_) seen_.push_back({t.t, t.position_m, t.velocity_mps});
    for (const RelativeEstimate& r : relatives_) seen_.push_back({r.t, r.position_m, r.velocity_mps});
    stages_.localization->see(seen_);
  }

  void map(const Observation& observation) {
    if (!stages_.mapping) return;
    begin(AgentStage::kMapping);
    const std::span<const NeighborSample> all = observation.neighbors;
    stages_.mapping->step({.observation = observation,
                           .estimate = action_.estimate,
                           .clouds = clouds_,
                           .tracks = tracks_,
                           .relatives = relatives_,
                           .neighbors = needs_.neighbors ? all : all.first(0),
                           .submaps = stages_.localization->submap_poses(),
                           .poses = &registrar_.poses()},
                          outbox_);
  }

  void guide(const Observation& observation, double dt_s) {
    begin(AgentStage::kGuidance);
    wanted_.goal_is_feasible = false;
    const StateEstimator::Search search = stages_.localization->search();
    const bool returns = way_back_.takes_over(action_.estimate, stages_.localization->should_return(), wanted_);
    if (!returns && needs_.world && search != StateEstimator::Search::kNone) {
      look_around_.step(dt_s, action_.estimate, search, wanted_);
      looks_around_ = true;
    } else if (!returns) {
      if (looks_around_) wanted_ = {};  // guidance sets only the changed outputs
      looks_around_ = false;
      step_guidance(observation, dt_s);
    }
    if (lost_) return;  // a mission that failed stays failed
    action_.mission = wanted_.mission;
    const char* warning = stages_.localization->warning();
    set_note(warning[0] == '\0' || returns ? wanted_.note : warning);
  }

  void step_guidance(const Observation& observation, double dt_s) {
    stages_.guidance->step({.dt_s = dt_s,
                            .estimate = action_.estimate,
                            .observation = observation,
                            .poses = registrar_.poses(),
                            .detections = found_.detections,
                            .tracks = tracks_,
                            .track_modes = track_modes_,
                            .relatives = relatives_,
                            .clouds = clouds_,
                            .map = stages_.mapping ? &stages_.mapping->map() : nullptr},
                           wanted_, outbox_);
  }

  void fly(double dt_s) {
    begin(AgentStage::kControl);
    if (!wanted_.motors_on) {
      action_.rotor_command = controller_.idle(dt_s);
      action_.reference = to_world_.reference(at_rest_with(action_.estimate));
      tracking_ = false;
      return;
    }
    ENSURE(is_finite(wanted_.goal), wanted_.goal.position_m, wanted_.goal.velocity_mps, wanted_.goal.yaw_rad);
    if (!tracking_) reference_governor_.reset(at_rest_with(action_.estimate));
    tracking_ = true;
    const Reference& reference = wanted_.goal_is_feasible
                                     ? reference_governor_.take(wanted_.goal, dt_s)
                                     : reference_governor_.step(wanted_.goal, dt_s, wanted_.speed_limit_mps);
    ENSURE(is_finite(reference), reference.position_m, reference.velocity_mps, reference.acceleration_mps2);
    action_.rotor_command = controller_.step(action_.estimate, reference, reference_governor_.jerk_mps3(), dt_s);
    action_.reference = to_world_.reference(reference);
    trail_.push(action_.estimate.t, reference.position_m);
  }

  /// Without a valid estimate a multirotor cannot fly: stops the rotors.
  void give_up(double dt_s) {
    begin(AgentStage::kOther);
    action_.rotor_command = controller_.idle(dt_s);
    action_.mission = MissionStatus::kFailed;
    set_note(stages_.localization->fault());
    lost_ = true;
    tracking_ = false;
  }

  void set_note(const char* note) {
    if (action_.mission_note != note) action_.mission_note = note;
  }

  void append_overlays() {
    action_.overlays.push_back(trail_.overlay("reference"));
    stages_.localization->append_overlays(action_.overlays);
    if (stages_.detector) stages_.detector->append_overlays(action_.overlays);
    if (stages_.tracker) track_overlays_.append(tracks_, action_.overlays);
    if (stages_.relative_localization) stages_.relative_localization->append_overlays(action_.overlays);
    if (stages_.mapping) stages_.mapping->append_overlays(action_.overlays);
    stages_.guidance->append_overlays(action_.overlays);
    for (Overlay& overlay : action_.overlays) to_world_.carry(overlay);
  }

  VehicleId self_;
  double tick_s_;
  StackStages stages_;
  GuidanceNeeds needs_;
  CloudRegistrar registrar_;
  ReferenceGovernor reference_governor_;
  MultirotorController controller_;
  const JoinedMapProvider* joined_map_provider_;  // null: localization joins no maps
  std::function<void(AgentStage)> begins_;        // called when a stage begins; may be empty

  Outbox outbox_;
  Action action_;
  // State of this tick, in the local frame.
  FrameChange to_world_;
  LocalCloudPool cloud_pool_;
  std::vector<std::shared_ptr<const LocalCloud>> clouds_;
  DetectorOutput found_;
  std::vector<Track> tracks_;            // newest tracks
  std::vector<TrackModes> track_modes_;  // modes of the tracks, if guidance needs them
  std::vector<RelativeEstimate> relatives_;
  std::vector<SeenVehicle> seen_;
  GuidanceOutput wanted_;
  LookAround look_around_;
  WayBack way_back_;
  bool looks_around_ = false;  // the vehicle searches for its pose; guidance does not run

  TrackOverlays track_overlays_;
  Trail trail_;
  TimeNs last_t_ = 0;
  bool started_ = false;
  bool tracking_ = false;  // the reference continues from the last tick
  bool lost_ = false;
};

}  // namespace

StackConfig::StackConfig()
    : localization(estimator_module_types(), "ground_truth"),
      detector(detector_module_types(), "none"),
      tracker(tracker_module_types(), "none"),
      relative_localization(relative_localizer_module_types(), "none"),
      mapping(mapper_module_types(), "none"),
      guidance(guidance_module_types(), "hover") {}

void StackConfig::visit(ConfigVisitor& v) {
  v.module("localization", localization, estimator_module_types(), "estimate of the vehicle's own pose");
  v.module("detector", detector, detector_module_types(), "detection of flying objects nearby");
  v.module("tracker", tracker, tracker_module_types(), "tracks of flying objects");
  v.module("relative_localization", relative_localization, relative_localizer_module_types(),
           "poses of other vehicles of the team");
  v.module("mapping", mapping, mapper_module_types(), "map of the surroundings");
  v.module("guidance", guidance, guidance_module_types(), "goals of the flight");
  v.object("control", control, "reference governor and controller");
}

std::unique_ptr<Agent> make_stack(StackStages stages, const ControlConfig& control, const AgentSetup& setup) {
  return std::make_unique<StackAgent>(std::move(stages), control, setup);
}

std::unique_ptr<Agent> make_stack(const ModuleConfig& config, const AgentSetup& setup) {
  const auto& stack = dynamic_cast<const StackConfig&>(config);
  StackStages stages;
  stages.localization = make_estimator(stack.localization, setup);
  stages.detector = make_detector(stack.detector, setup);
  stages.tracker = make_tracker(stack.tracker, setup);
  stages.relative_localization = make_relative_localizer(stack.relative_localization, setup);
  stages.mapping = make_mapper(stack.mapping, setup);
  stages.guidance = make_guidance(stack.guidance, {setup, stack.control.limits.resolve()});
  return make_stack(std::move(stages), stack.control, setup);
}

AgentNeeds stack_needs(const ModuleConfig& config) {
  const auto& stack = dynamic_cast<const StackConfig&>(config);
  AgentNeeds needs;
  const auto add = [&](const auto& registry, const Module& stage) {
    const auto& row = registry.named(stage.type);
    if (row.add_needs != nullptr) row.add_needs(*stage.config, needs);
  };
  add(estimator_registry(), stack.localization);
  add(detector_registry(), stack.detector);
  add(tracker_registry(), stack.tracker);
  add(mapper_registry(), stack.mapping);
  add(guidance_registry(), stack.guidance);
  return needs;
}

std::optional<std::vector<std::string>> stack_overlays(const ModuleConfig& config) {
  const auto& stack = dynamic_cast<const StackConfig&>(config);
  std::vector<std::string> names = {"reference", "tracks", "tracks.covariance"};
  bool all_known = true;
  // Overlays of all types, so that a camera need not change with the chosen stages.
  const auto add = [&](const auto& registry, const Module& chosen) {
    for (const auto& row : registry.rows()) {
      std::istringstream drawn(row.overlays != nullptr ? row.overlays : "");
      std::copy(std::istream_iterator<std::string>(drawn), {}, std::back_inserter(names));
    }
    all_known = all_known && registry.named(chosen.type).overlays != nullptr;
  };
  add(estimator_registry(), stack.localization);
  add(detector_registry(), stack.detector);
  add(relative_localizer_registry(), stack.relative_localization);
  add(mapper_registry(), stack.mapping);
  add(guidance_registry(), stack.guidance);
  if (!all_known) return std::nullopt;
  return names;
}

Module* stack_guidance(ModuleConfig& config) { return &dynamic_cast<StackConfig&>(config).guidance; }

}  // namespace swiftlet
