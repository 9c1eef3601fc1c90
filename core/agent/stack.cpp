// SPDX-License-Identifier: BSD-3-Clause
#include "core/agent/stack.hpp"

#include <cmath>

#include "core/control/controller.hpp"
#include "core/control/reference_tracker.hpp"
#include "core/stages/detectors.hpp"
#include "core/stages/guidances.hpp"
#include "core/stages/estimators.hpp"
#include "core/localization/world_cloud.hpp"
#include "core/stages/trackers.hpp"
#include "core/tracking/track_overlays.hpp"

namespace swiftlet {
namespace {

/// A reference that starts where and as the vehicle is.
Reference at_rest_with(const StateEstimate& estimate) {
  Reference reference;
  reference.position_m = estimate.T_world_body.translation();
  reference.velocity_mps = estimate.v_world_mps;
  reference.yaw_rad = yaw_of(estimate.T_world_body.linear());
  return reference;
}

/// The last seconds of the reference's path, for pictures.
class Trail {
 public:
  void push(TimeNs t, const Vector3& p_m) {
    if (count_ > 0 && t - last_ < kNsPerSecond / 20) return;
    last_ = t;
    points_[(first_ + count_) % kCapacity] = p_m.cast<float>();
    if (count_ < kCapacity)
      ++count_;
    else
      first_ = (first_ + 1) % kCapacity;
  }
  Overlay overlay() const {
    Overlay out;
    out.name = "reference";
    out.kind = Overlay::Kind::kPolyline;
    for (int i = 0; i < count_; ++i) out.positions.push_back(points_[(first_ + i) % kCapacity]);
    out.colors = {{0.1F, 0.6F, 1.0F, 1.0F}};
    out.size_m = 2.0F;
    return out;
  }

 private:
  static constexpr int kCapacity = 600;  // 30 s
  std::array<Eigen::Vector3f, kCapacity> points_{};
  int first_ = 0, count_ = 0;
  TimeNs last_ = 0;
};

class StackAgent : public Agent {
 public:
  StackAgent(const StackConfig& config, const AgentSetup& setup)
      : setup_(setup),
        estimator_(make_estimator(config.localization, setup)),
        registrar_(setup.airframe.circumscribed_radius_m()),
        detector_(make_detector(config.detector, setup)),
        target_tracker_(make_tracker(config.tracker, setup)),
        tracker_(config.control.limits.resolve()),
        guidance_(make_guidance(config.guidance, {setup_, tracker_.limits()})),
        controller_(setup.airframe, config.control.gains, setup.tick_s) {}

  const Action& step(const Observation& observation) override {
    const double dt_s = started_ ? to_seconds(observation.t - last_t_) : setup_.tick_s;
    if (started_ && dt_s <= 0.0) return action_;  // the same instant again: nothing new to do
    last_t_ = observation.t;
    started_ = true;
    action_.clear_outputs();

    action_.estimate = estimator_->update(observation);
    if (!action_.estimate.valid) {
      give_up(dt_s);
      return action_;
    }
    perceive(observation);
    guide(observation, dt_s);
    fly(dt_s);
    if (observation.wants_overlays) append_overlays();
    return action_;
  }

 private:
  /// Scans become clouds in the world of the estimate, which all modules that look at scans share.
  void perceive(const Observation& observation) {
    if (detector_ == nullptr && target_tracker_ == nullptr) return;
    registrar_.push(action_.estimate);
    clouds_.clear();
    for (const auto& scan : observation.scans) {
      if (auto cloud = cloud_pool_.make(scan, registrar_)) clouds_.push_back(std::move(cloud));
    }
    detect(observation);
    track(observation);
  }

  void detect(const Observation& observation) {
    if (detector_ == nullptr) return;
    found_.clear();
    detector_->step({observation.t, action_.estimate, clouds_, observation}, found_);
    action_.has_detections = found_.has_detections;
    action_.detections_stamp = found_.stamp;
    action_.detections.assign(found_.detections.begin(), found_.detections.end());
  }

  void track(const Observation& observation) {
    if (target_tracker_ == nullptr) return;
    TrackerInput input{.observation = observation, .estimate = action_.estimate, .clouds = clouds_};
    input.has_detections = action_.has_detections;
    input.detections = action_.detections;
    input.background = detector_ != nullptr ? detector_->map() : nullptr;
    action_.has_tracks = target_tracker_->step(input, action_.tracks);
    if (action_.has_tracks) track_overlays_.push(action_.tracks);
  }

  void guide(const Observation& observation, double dt_s) {
    wanted_.messages.clear();
    guidance_->step({.dt_s = dt_s,
                     .estimate = action_.estimate,
                     .observation = observation,
                     .detections = action_.detections,
                     .tracks = action_.tracks},
                    wanted_);
    action_.messages.swap(wanted_.messages);
    if (lost_) return;  // a mission that failed stays failed
    action_.mission = wanted_.mission;
    set_note(wanted_.note);
  }

  void fly(double dt_s) {
    if (!wanted_.motors_on) {
      action_.rotor_command = controller_.idle(dt_s);
      action_.reference = at_rest_with(action_.estimate);
      tracking_ = false;
      return;
    }
    if (!tracking_) tracker_.reset(at_rest_with(action_.estimate));
    tracking_ = true;
    action_.reference = tracker_.step(wanted_.goal, dt_s, wanted_.speed_limit_mps);
    action_.rotor_command = controller_.step(action_.estimate, action_.reference, tracker_.jerk_mps3(), dt_s);
    trail_.push(action_.estimate.t, action_.reference.position_m);
  }

  /// Without knowing where it is, a multirotor cannot fly on.
  void give_up(double dt_s) {
    action_.rotor_command = controller_.idle(dt_s);
    action_.mission = MissionStatus::kFailed;
    set_note(estimator_->fault());
    lost_ = true;
    tracking_ = false;
  }

  void set_note(const char* note) {
    if (action_.mission_note != note) action_.mission_note = note;
  }

  void append_overlays() {
    action_.overlays.push_back(trail_.overlay());
    if (detector_ != nullptr) detector_->append_overlays(action_.overlays);
    if (target_tracker_ != nullptr) track_overlays_.append(action_.tracks, action_.overlays);
    guidance_->append_overlays(action_.overlays);
  }

  AgentSetup setup_;
  std::unique_ptr<StateEstimator> estimator_;
  CloudRegistrar registrar_;
  std::unique_ptr<Detector> detector_;       // null: none
  std::unique_ptr<Tracker> target_tracker_;  // null: none
  ReferenceTracker tracker_;
  std::unique_ptr<Guidance> guidance_;
  MultirotorController controller_;

  Action action_;
  GuidanceOutput wanted_;
  WorldCloudPool cloud_pool_;
  std::vector<std::shared_ptr<const WorldCloud>> clouds_;  // of this tick
  DetectorOutput found_;
  TrackOverlays track_overlays_;
  Trail trail_;
  TimeNs last_t_ = 0;
  bool started_ = false;
  bool tracking_ = false;  // the tracked reference goes on from where it was
  bool lost_ = false;
};

}  // namespace

StackConfig::StackConfig()
    : localization(estimator_module_types(), "ground_truth"),
      detector(detector_module_types(), "none"),
      tracker(tracker_module_types(), "none"),
      guidance(guidance_module_types(), "hover") {}

void StackConfig::visit(ConfigVisitor& v) {
  v.module("localization", localization, estimator_module_types(), "where am I");
  v.module("detector", detector, detector_module_types(), "who flies near me");
  v.module("tracker", tracker, tracker_module_types(), "where they fly and will fly");
  v.module("guidance", guidance, guidance_module_types(), "where to go");
  v.object("control", control, "how to fly there");
}

std::unique_ptr<Agent> make_stack(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<StackAgent>(dynamic_cast<const StackConfig&>(config), setup);
}

}  // namespace swiftlet
