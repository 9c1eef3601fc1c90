// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/events.hpp"

#include <nlohmann/json.hpp>

#include "sim/recorders/selection.hpp"
#include "swiftlet/sim/io/output_file.hpp"

namespace swiftlet::sim {
namespace {

constexpr const char* kFile = "events.jsonl";

/// Visitor that creates a JSON object of an event.
class EventLine {
 public:
  EventLine(const std::vector<std::string>& vehicle_names, TimeNs start_time)
      : names_(vehicle_names), start_time_(start_time) {}

  // A division rounds correctly: 0.09, not 0.09000000000000001.
  void time(const char* name, TimeNs t, const char*) { line_[name] = static_cast<double>(start_time_ + t) / 1e9; }
  void field(const char* name, const std::string& text, const char*) { line_[name] = text; }
  void field(const char* name, const Vector3& v, const char*) {
    std::string key = name;
    key.erase(key.find("_*"), 2);
    line_[key] = {v.x(), v.y(), v.z()};
  }
  void vehicle(const char* name, VehicleId id, const char*) {
    line_[name] = id == kNoVehicle ? nlohmann::ordered_json() : nlohmann::ordered_json(names_[id]);
  }
  // Names may come from files in any encoding: invalid UTF-8 is replaced.
  std::string text() const { return line_.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace); }

 private:
  const std::vector<std::string>& names_;
  TimeNs start_time_;
  nlohmann::ordered_json line_;
};

class EventsRecorder : public Recorder {
 public:
  explicit EventsRecorder(EventsConfig config) : config_(std::move(config)) {}

  void begin(const RunInfo& info) override {
    names_ = info.vehicle_names;
    start_time_ = info.start_time;
    selected_ = select_vehicles(config_.vehicles, names_);
    file_ = OutputFile(info.directory / kFile);
  }

  void write(const TickView& tick) override {
    for (const Event& event : tick.events) {
      const bool about_a_vehicle = event.vehicle != kNoVehicle;
      if (!selects(config_.kinds, event.kind) || (about_a_vehicle && !selected_[event.vehicle])) continue;
      EventLine line(names_, start_time_);
      Event::visit(event, line);
      file_.append(line.text() + '\n');
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
  TimeNs start_time_ = 0;
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
