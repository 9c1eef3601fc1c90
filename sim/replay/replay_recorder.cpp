// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "sim/replay/block.hpp"
#include "sim/replay/overlay_tables.hpp"
#include "sim/replay/page.hpp"
#include "sim/replay/rows.hpp"
#include "sim/replay/scan_tables.hpp"
#include "sim/replay/world_tables.hpp"
#include "swiftlet/sim/io/output_file.hpp"
#include "swiftlet/sim/recorders/state_row.hpp"
#include "swiftlet/sim/render/colors.hpp"
#include "swiftlet/sim/replay/live_server.hpp"
#include "swiftlet/sim/replay/replay.hpp"

namespace swiftlet::sim {
namespace {

using Json = nlohmann::ordered_json;

// [ns] Time span of a block in a file, and in the page of a run in progress. Larger values compress better and arrive
// later.
constexpr TimeNs kChunk = 2'000'000'000, kLiveChunk = 200'000'000;
constexpr TimeNs kRadioBin = 200'000'000;   // interval for counting messages of a pair of vehicles
constexpr std::size_t kFirstPoints = 2500;  // points per scan, before their size is measured
// [-] Bounds of the points of a thinned scan.
constexpr std::size_t kFewestPoints = 200, kMaxPoints = 60000;

/// Names may come from files in any encoding: invalid UTF-8 is replaced.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json bytes_of(const Rgb& color) {
  Json bytes;
  for (int c = 0; c < 3; ++c) bytes.push_back(std::lround(255.0F * std::clamp(color[c], 0.0F, 1.0F)));
  return bytes;
}

/// The renderer's colors, so that page and pictures of a run agree.
Json palette(std::size_t vehicles) {
  constexpr int kSteps = 32;
  Json out;
  for (std::size_t v = 0; v < vehicles; ++v)
    out["vehicles"].push_back(bytes_of(vehicle_color(static_cast<VehicleId>(v))));
  for (int i = 0; i <= kSteps; ++i) {
    const float s = static_cast<float>(i) / kSteps;
    out["height"].push_back(bytes_of(height_color(s)));
    out["intensity"].push_back(bytes_of(viridis_like(s)));
  }
  const auto add_class = [&](SurfaceClass c) {
    out["classes"].push_back({{"number", static_cast<int>(c)},
                              {"name", name_of(c)},
                              {"color", bytes_of(class_color(static_cast<std::uint16_t>(c)))}});
  };
  for (const char* name : static_class_names()) add_class(*surface_class_of(name));
  add_class(SurfaceClass::kVehicle);
  return out;
}

/// True at the first instant at or after every multiple of a period; period 0: never.
class Gate {
 public:
  explicit Gate(TimeNs period = 0) : period_(period) {}
  bool is_due(TimeNs t) const { return period_ > 0 && t >= next_; }
  bool pass(TimeNs t) {
    if (!is_due(t)) return false;
    next_ = (t / period_ + 1) * period_;
    return true;
  }

 private:
  TimeNs period_, next_ = 0;
};

TimeNs period_of(double rate_hz) { return rate_hz > 0.0 ? from_seconds(1.0 / rate_hz) : 0; }

/// Number of points per scan that keeps the requested data rate; updated after each chunk.
class PointBudget {
 public:
  PointBudget(double kBps, TimeNs chunk) : bytes_per_chunk_(1e3 * kBps * to_seconds(chunk)) {}
  std::size_t points_per_scan() const { return points_per_scan_; }
  void count(std::size_t points) {
    points_ += points;
    ++scans_;
  }
  void end_chunk(std::size_t bytes) {
    if (points_ > 0) {
      const double bytes_per_point = static_cast<double>(bytes) / static_cast<double>(points_);
      const double wanted = bytes_per_chunk_ / (bytes_per_point * static_cast<double>(scans_));
      points_per_scan_ = static_cast<std::size_t>(
          std::clamp(wanted, static_cast<double>(kFewestPoints), static_cast<double>(kMaxPoints)));
    }
    points_ = scans_ = 0;
  }

 private:
  double bytes_per_chunk_;
  std::size_t points_per_scan_ = kFirstPoints, points_ = 0, scans_ = 0;
};

/// Destination of the packed blocks, in order.
class BlockSink {
 public:
  virtual ~BlockSink() = default;
  virtual void begin(const RunInfo& info) = 0;
  virtual void put(std::string packed) = 0;
  virtual std::vector<std::filesystem::path> finish() = 0;
};

class PageFile : public BlockSink {
 public:
  explicit PageFile(std::filesystem::path path) : path_(std::move(path)) {}
  void begin(const RunInfo& info) override {
    directory_ = info.directory;
    file_ = OutputFile(path_.empty() ? directory_ / "replay.html" : path_);
    file_.append(page_head());
  }
  void put(std::string packed) override { file_.append(page_block(packed)); }
  std::vector<std::filesystem::path> finish() override {
    file_.append(page_tail());
    file_.finish();
    return {file_.path().lexically_proximate(directory_)};
  }

 private:
  std::filesystem::path path_, directory_;
  OutputFile file_;
};

class LivePage : public BlockSink {
 public:
  explicit LivePage(LiveServer& server) : server_(server) {}
  void begin(const RunInfo&) override {}
  void put(std::string packed) override { server_.put(std::move(packed)); }
  std::vector<std::filesystem::path> finish() override { return {}; }

 private:
  LiveServer& server_;
};

class ReplayRecorder : public Recorder {
 public:
  /// @param chunk  time span of a block
  ReplayRecorder(ReplayConfig config, std::unique_ptr<BlockSink> sink, TimeNs chunk)
      : config_(config),
        sink_(std::move(sink)),
        chunk_length_(chunk),
        state_gate_(period_of(config.rate_hz)),
        overlay_gate_(period_of(config.overlay_rate_hz)),
        budget_(config.scan_budget_kBps, chunk),
        overlays_(from_seconds(config.map_period_s)) {}

  void begin(const RunInfo& info) override;
  bool wants_overlays(TimeNs now) const override { return overlay_gate_.is_due(now); }
  void write(const TickView& tick) override;
  std::vector<std::filesystem::path> finish() override;

 private:
  void put(const ReplayBlock& block) { sink_->put(gzip(block.bytes())); }
  Json head() const;
  void write_states(const TickView& tick);
  void write_series(const TickView& tick);
  void write_scans(const TickView& tick);
  void write_perception(const TickView& tick);
  void write_radio(const TickView& tick);
  void write_events(const TickView& tick);
  void end_radio_bin();
  void end_chunk();

  struct Traffic {
    double messages = 0.0, bytes = 0.0;
  };

  ReplayConfig config_;
  std::unique_ptr<BlockSink> sink_;
  TimeNs chunk_length_;
  RunInfo info_;
  Gate state_gate_, overlay_gate_;
  PointBudget budget_;
  OverlayTables overlays_;
  std::vector<Rows> states_;                                      // indexed by vehicle
  std::map<std::pair<std::string, VehicleId>, Rows> series_;      // indexed by table and vehicle
  std::map<std::string, TimeNs> series_taken_;                    // time of the last rows written, by table
  std::map<std::pair<VehicleId, std::string>, Gate> scan_gates_;  // indexed by vehicle and sensor
  std::map<std::pair<VehicleId, std::string>, std::uint64_t> scan_counts_;
  // Indexed by sender and receiver, in the current interval
  std::map<std::pair<VehicleId, VehicleId>, Traffic> traffic_;
  TimeNs bin_ = 0, chunk_ = 0, now_ = 0;
  ReplayBlock scans_{R"({"kind":"scans"})"};
  ReplayTable detections_{R"({"table":"detections"})",
                          {{"t_s", 1e-3},
                           {"vehicle", 1},
                           {"x_m", 0.01},
                           {"y_m", 0.01},
                           {"z_m", 0.01},
                           {"extent_x_m", 0.01},
                           {"extent_y_m", 0.01},
                           {"extent_z_m", 0.01},
                           {"points", 1},
                           {"confidence", 0.01}}};
  ReplayTable tracks_{R"({"table":"tracks"})",
                      {{"t_s", 1e-3},
                       {"vehicle", 1},
                       {"id", 1},
                       {"x_m", 0.01},
                       {"y_m", 0.01},
                       {"z_m", 0.01},
                       {"vx_mps", 0.01},
                       {"vy_mps", 0.01},
                       {"vz_mps", 0.01},
                       {"xx", 1e-4},
                       {"xy", 1e-4},
                       {"xz", 1e-4},
                       {"yy", 1e-4},
                       {"yz", 1e-4},
                       {"zz", 1e-4},
                       {"corrected", 1},
                       {"detections", 1}}};
  ReplayTable clouds_taken_{R"({"table":"track_updates"})", {{"t_s", 1e-3}, {"vehicle", 1}}};
  ReplayTable radio_{R"({"table":"radio"})", {{"t_s", 1e-3}, {"from", 1}, {"to", 1}, {"messages", 1}, {"bytes", 1}}};
  Json events_ = Json::array();
};

Json ReplayRecorder::head() const {
  Json head = {{"kind", "head"}, {"format", 1}, {"scenario", info_.scenario}};
  head["vehicles"] = info_.vehicle_names;
  head["palette"] = palette(info_.vehicle_names.size());
  head["rates"] = {
      {"state_hz", config_.rate_hz}, {"scan_hz", config_.scan_rate_hz}, {"overlay_hz", config_.overlay_rate_hz}};
  if (info_.scene != nullptr) {
    const auto& box = info_.scene->bounds_m;
    head["bounds_m"] = {{box.min().x(), box.min().y(), box.min().z()}, {box.max().x(), box.max().y(), box.max().z()}};
    head["triangles"] = info_.scene->num_triangles();
  }
  return head;
}

void ReplayRecorder::begin(const RunInfo& info) {
  info_ = info;
  sink_->begin(info);
  ReplayBlock vehicles(text_of(head()));
  for (std::size_t v = 0; v < info.vehicle_names.size(); ++v) {
    if (info.vehicle_shapes[v]) append_vehicle(*info.vehicle_shapes[v], static_cast<VehicleId>(v), vehicles);
    states_.emplace_back(Json::object({{"table", "state"}, {"vehicle", v}}).dump());
  }
  put(vehicles);
  if (info.scene == nullptr) return;
  ReplayBlock world(R"({"kind":"world"})");
  append_world(*info.scene, static_cast<std::size_t>(config_.world_triangles), world);
  put(world);
}

void ReplayRecorder::write(const TickView& tick) {
  now_ = tick.t;
  if (tick.t >= bin_ + kRadioBin) end_radio_bin();
  if (tick.t >= chunk_ + chunk_length_) end_chunk();
  if (state_gate_.pass(tick.t)) write_states(tick);
  write_series(tick);
  write_scans(tick);
  write_perception(tick);
  write_radio(tick);
  write_events(tick);
  if (overlay_gate_.pass(tick.t)) overlays_.write(tick);
}

void ReplayRecorder::write_states(const TickView& tick) {
  for (std::size_t v = 0; v < tick.states.size(); ++v) {
    put_state(tick, static_cast<VehicleId>(v), info_.airframes[v]->num_rotors(), states_[v].begin_row());
    states_[v].end_row();
  }
}

// Tables of metrics may have rows in every tick: they are thinned to the rate of the states.
void ReplayRecorder::write_series(const TickView& tick) {
  for (const Series* table : info_.series) {
    if (table->size() == 0) continue;
    const auto taken = series_taken_.find(table->name());
    if (taken != series_taken_.end() && tick.t - taken->second < period_of(config_.rate_hz)) continue;
    series_taken_[table->name()] = tick.t;
    for (std::size_t i = 0; i < table->size(); ++i) {
      const VehicleId about = table->about(i);
      Rows& rows = series_
                       .try_emplace({table->name(), about},
                                    text_of({{"table", "series"}, {"name", table->name()}, {"vehicle", about}}))
                       .first->second;
      table->put(i, rows.begin_row());
      rows.end_row();
    }
  }
}

void ReplayRecorder::write_scans(const TickView& tick) {
  for (std::size_t v = 0; v < tick.scans.size(); ++v) {
    for (const auto& scan : tick.scans[v]) {
      const std::pair key(static_cast<VehicleId>(v), scan->scan.sensor);
      Gate& gate = scan_gates_.try_emplace(key, period_of(config_.scan_rate_hz)).first->second;
      if (!gate.pass(tick.t)) continue;
      budget_.count(append_scan(*scan, key.first, budget_.points_per_scan(), scan_counts_[key]++, scans_));
    }
  }
}

void ReplayRecorder::write_perception(const TickView& tick) {
  for (std::size_t v = 0; v < tick.actions.size(); ++v) {
    if (tick.actions[v] == nullptr) continue;
    const Action& action = *tick.actions[v];
    const auto vehicle = static_cast<double>(v);
    for (const Detection& d : action.detections) {
      const Vector3 &p = d.position_m, &e = d.extent_m;
      detections_.add({to_seconds(tick.t), vehicle, p.x(), p.y(), p.z(), e.x(), e.y(), e.z(),
                       static_cast<double>(d.num_points), d.confidence});
    }
    if (!action.has_tracks) continue;
    clouds_taken_.add({to_seconds(tick.t), vehicle});
    for (const Track& t : action.tracks) {
      const Vector3 &p = t.position_m, &w = t.velocity_mps;
      const auto& C = t.covariance;
      tracks_.add({to_seconds(tick.t), vehicle, static_cast<double>(t.id), p.x(), p.y(), p.z(), w.x(), w.y(), w.z(),
                   C(0, 0), C(0, 1), C(0, 2), C(1, 1), C(1, 2), C(2, 2), t.corrected ? 1.0 : 0.0,
                   static_cast<double>(t.num_detections)});
    }
  }
}

void ReplayRecorder::write_radio(const TickView& tick) {
  for (std::size_t v = 0; v < tick.observations.size(); ++v) {
    for (const Message& message : tick.observations[v].messages) {
      Traffic& traffic = traffic_[{message.from, static_cast<VehicleId>(v)}];
      traffic.messages += 1.0;
      traffic.bytes += static_cast<double>(message.size_bytes());
    }
  }
}

void ReplayRecorder::end_radio_bin() {
  for (const auto& [pair, traffic] : traffic_) {
    radio_.add({to_seconds(bin_), static_cast<double>(pair.first), static_cast<double>(pair.second), traffic.messages,
                traffic.bytes});
  }
  traffic_.clear();
  bin_ = now_ / kRadioBin * kRadioBin;
}

void ReplayRecorder::write_events(const TickView& tick) {
  for (const Event& event : tick.events) {
    events_.push_back({{"t_s", to_seconds(event.t)},
                       {"kind", event.kind},
                       {"vehicle", event.vehicle},
                       {"partner", event.partner},
                       {"position_m", {event.p_world_m.x(), event.p_world_m.y(), event.p_world_m.z()}},
                       {"note", event.note}});
  }
}

void ReplayRecorder::end_chunk() {
  ReplayBlock chunk(text_of({{"kind", "chunk"}, {"t_s", to_seconds(chunk_)}, {"events", events_}}));
  for (Rows& rows : states_) rows.move_to(chunk);
  for (auto& [key, rows] : series_) rows.move_to(chunk);
  for (ReplayTable* table : {&detections_, &tracks_, &clouds_taken_, &radio_}) {
    chunk.add(*table);
    table->clear();
  }
  overlays_.move_to(chunk);
  put(chunk);
  std::string scans = scans_.empty() ? "" : gzip(scans_.bytes());
  budget_.end_chunk(scans.size());
  if (!scans.empty()) sink_->put(std::move(scans));
  scans_ = ReplayBlock(R"({"kind":"scans"})");
  events_ = Json::array();
  chunk_ = now_ / chunk_length_ * chunk_length_;
}

std::vector<std::filesystem::path> ReplayRecorder::finish() {
  end_radio_bin();
  end_chunk();
  put(ReplayBlock(text_of({{"kind", "end"}, {"t_s", to_seconds(now_)}})));
  return sink_->finish();
}

}  // namespace

void ReplayConfig::visit(ConfigVisitor& v) {
  v.field("rate_hz", rate_hz, "[Hz] rate of the states of the vehicles and of the tables of metrics",
          Range::between(1.0, 1000.0));
  v.field("scan_rate_hz", scan_rate_hz, "[Hz] rate of the scans of each LiDAR; 0: none", Range::between(0.0, 1000.0));
  v.field("scan_budget_kBps", scan_budget_kBps, "[kB/s] data rate of all scans together; larger scans are thinned",
          Range::between(1.0, 1e5));
  v.field("overlay_rate_hz", overlay_rate_hz, "[Hz] rate of overlays such as cells and paths; 0: none",
          Range::between(0.0, 1000.0));
  v.field("map_period_s", map_period_s, "[s] period of large overlays such as maps and voxels; 0: none",
          Range::between(0.0, 1e6));
  v.field("world_triangles", world_triangles,
          "[-] largest number of triangles of the world; a larger world is coarsened", Range::between(1000, 10000000));
}

std::unique_ptr<Recorder> make_replay_recorder(const ModuleConfig& config) {
  return make_replay_recorder(dynamic_cast<const ReplayConfig&>(config), {});
}

std::unique_ptr<Recorder> make_replay_recorder(const ReplayConfig& config, const std::filesystem::path& file) {
  return std::make_unique<ReplayRecorder>(config, std::make_unique<PageFile>(file), kChunk);
}

std::unique_ptr<Recorder> make_live_recorder(const ReplayConfig& config, LiveServer& server) {
  return std::make_unique<ReplayRecorder>(config, std::make_unique<LivePage>(server), kLiveChunk);
}

}  // namespace swiftlet::sim
