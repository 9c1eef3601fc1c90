// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/events.hpp"

#include <nlohmann/json.hpp>

#include "sim/io/output_file.hpp"
#include "sim/recorders/selection.hpp"

namespace swiftlet::sim {
namespace {

constexpr const char* kFile = "events.jsonl";

class EventsRecorder : public Recorder {
 public:
  explicit EventsRecorder(EventsConfig config) : config_(std::move(config)) {}

  void begin(const RunInfo& info) override {
    names_ = info.vehicle_names;
    selected_ = select_vehicles(config_.vehicles, names_);
    file_ = OutputFile(info.directory / kFile);
  }

  void write(const TickView& tick) override {
    for (const Event& event : tick.events) {
      const bool about_a_vehicle = event.vehicle != kNoVehicle;
      if (!selects(config_.kinds, event.kind) || (about_a_vehicle && !selected_[event.vehicle])) continue;
      nlohmann::ordered_json line;
      line["t_s"] = static_cast<double>(event.t) / 1e9;  // a division rounds right: 0.09, not 0.09000000000000001
      line["kind"] = event.kind;
      if (about_a_vehicle) {
        line["vehicle"] = names_[event.vehicle];
      } else {
        line["vehicle"] = nullptr;
      }
      line["partner"] = event.partner;
      line["position_m"] = {event.p_world_m.x(), event.p_world_m.y(), event.p_world_m.z()};
      line["note"] = event.note;
      // Names may come from files in any encoding: what is not UTF-8 is replaced rather than refused.
      file_.append(line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n');
    }
  }

  std::vector<std::filesystem::path> finish() override {
    file_.finish();
    return {kFile};
  }

 private:
  EventsConfig config_;
  std::vector<std::string> names_;
  std::vector<bool> selected_;
  OutputFile file_;
};

}  // namespace

void EventsConfig::visit(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles whose events are written; empty: all");
  v.field("kinds", kinds, "[-] kinds of events to write, such as crash; empty: all");
}

std::unique_ptr<Recorder> make_events_recorder(const ModuleConfig& config) {
  return std::make_unique<EventsRecorder>(dynamic_cast<const EventsConfig&>(config));
}

}  // namespace swiftlet::sim
