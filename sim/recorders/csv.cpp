// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/csv.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "sim/recorders/selection.hpp"
#include "swiftlet/core/base/fields.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/sim/io/output_file.hpp"
#include "swiftlet/sim/io/text_row.hpp"
#include "swiftlet/sim/metrics/metrics.hpp"
#include "swiftlet/sim/recorders/state_row.hpp"

namespace swiftlet::sim {
namespace {

/// Formats the values of one row as text.
class CsvRow final : public ColumnSink {
 public:
  CsvRow(std::vector<std::string> vehicle_names, TimeNs start_time)
      : names_(std::move(vehicle_names)), start_time_(start_time) {}

  void time(const ColumnName&, TimeNs t) override { row_.add_seconds(start_time_ + t); }
  void number(const ColumnName&, double value) override { row_.add(value); }
  void integer(const ColumnName&, std::int64_t value) override { row_.add(value); }
  void flag(const ColumnName&, bool value) override { row_.add(static_cast<int>(value)); }
  void text(const ColumnName&, std::string_view value) override { row_.add(value); }
  void vehicle(const ColumnName&, VehicleId id) override {
    row_.add(id == kNoVehicle ? std::string_view() : std::string_view(names_[id]));
  }
  void missing(const ColumnName&) override { row_.add(std::numeric_limits<double>::quiet_NaN()); }

  void clear() { row_.clear(); }
  std::string_view line() { return row_.line(); }

 private:
  std::vector<std::string> names_;
  TimeNs start_time_;
  TextRow row_{','};
};

/// A CSV file with column names in the first line. The file is created by open() or with the first row.
class Table {
 public:
  Table(std::filesystem::path directory, std::string name, const std::vector<Column>& columns)
      : path_(std::move(directory) / name), name_(std::move(name)) {
    for (const Column& column : columns) header_ += (header_.empty() ? "" : ",") + column.name;
    header_ += "\n";
  }

  void open() {
    file_ = OutputFile(path_);
    file_.append(header_);
  }
  void append(std::string_view line) {
    if (!file_.is_open()) open();
    file_.append(line);
  }
  /// @return path of the file relative to the run's directory; empty when no file was opened
  std::optional<std::filesystem::path> finish() {
    if (!file_.is_open()) return std::nullopt;
    file_.finish();
    return name_;
  }

 private:
  std::filesystem::path path_;
  std::string name_, header_;
  OutputFile file_;
};

/// Tick, vehicle and destination of the rows that a topic writes.
struct Source {
  const TickView& tick;
  VehicleId vehicle;
  CsvRow& row;
  Table& table;

  const Observation& observation() const { return tick.observations[vehicle]; }
  const Action& action() const {
    static const Action kNone;
    return tick.actions[vehicle] ? *tick.actions[vehicle] : kNone;
  }
  ColumnSink& begin_row() const {
    row.clear();
    return row;
  }
  void end_row() const { table.append(row.line()); }
};

/// Type of table of a vehicle or of the whole run, such as the state or the tracks.
struct Topic {
  std::string name;
  std::vector<Column> columns;
  std::function<void(const Source&)> write;  ///< writes the rows of one tick
  bool sampled = false;                      ///< true: written at rate_hz; false: written in every tick that has data
};

Topic state_topic(int num_rotors) {
  ColumnList columns;
  put_state({}, 0.0, {}, num_rotors, columns);
  const auto write = [num_rotors](const Source& source) {
    put_state(source.tick, source.vehicle, num_rotors, source.begin_row());
    source.end_row();
  };
  return {"state", columns.columns(), write, true};
}

Topic series_topic(const Series& series) {
  const auto write = [&series](const Source& source) {
    for (std::size_t i = 0; i < series.size(); ++i) {
      if (series.about(i) != source.vehicle) continue;
      series.put(i, source.begin_row());
      source.end_row();
    }
  };
  return {series.name(), series.columns(), write};
}

/// Topic with one row for each value that `values_of` returns for a tick.
template <class Kind, class ValuesOf>
Topic topic_of(ValuesOf values_of) {
  const auto write = [values_of](const Source& source) {
    for (const Kind& value : values_of(source)) {
      put_columns(value, source.begin_row());
      source.end_row();
    }
  };
  return {Kind::kName, columns_of<Kind>(), write};
}

/// Topic of samples whose type is not a member of Observation (Observation::others), such as those of plug-in sensors.
Topic samples_topic(TableType table) {
  const auto write = [name = table.name](const Source& source) {
    for (const auto& samples : source.observation().others) {
      for (std::size_t i = 0; samples->name() == name && i < samples->size(); ++i) {
        samples->put(i, source.begin_row());
        source.end_row();
      }
    }
  };
  return {std::move(table.name), std::move(table.columns), write};
}

/// Topic of the received messages of one kind.
Topic message_topic(const MessageKind& kind) {
  const auto write = [&kind](const Source& source) {
    for (const Message& message : source.observation().messages) {
      if (kind.read(message, nullptr) != Reading::kDone) continue;
      put_message(kind, message, source.begin_row());
      source.end_row();
    }
  };
  return {"message_" + std::string(kind.topic), message_columns(kind), write};
}

/// Topics that every vehicle has.
std::vector<Topic> vehicle_topics(int num_rotors) {
  std::vector<Topic> topics{state_topic(num_rotors)};
  const Observation nothing;
  Observation::each_samples(nothing, [&]<class Sample>(const std::vector<Sample>&) {
    topics.push_back(topic_of<Sample>([](const Source& source) { return samples_of<Sample>(source.observation()); }));
  });
  for (const TableType& table : sample_tables()) topics.push_back(samples_topic(table));
  topics.push_back(topic_of<Detection>([](const Source& source) { return std::span(source.action().detections); }));
  topics.push_back(topic_of<Track>([](const Source& source) {
    const Action& action = source.action();
    return action.has_tracks ? std::span(action.tracks) : std::span<const Track>();
  }));
  topics.push_back(
      topic_of<RelativeEstimate>([](const Source& source) { return std::span(source.action().relatives); }));
  topics.push_back(topic_of<Message>([](const Source& source) { return std::span(source.observation().messages); }));
  for (const MessageKind& kind : message_kinds()) topics.push_back(message_topic(kind));
  return topics;
}

std::vector<std::string> csv_topic_names() {
  std::vector<std::string> names;
  for (TableType& table : csv_tables()) names.push_back(std::move(table.name));
  return names;
}

class CsvRecorder : public Recorder {
 public:
  explicit CsvRecorder(CsvConfig config) : config_(std::move(config)), gate_(config_.rate_hz) {}

  void begin(const RunInfo& info) override {
    row_.emplace(info.vehicle_names, info.start_time);
    const std::vector<bool> selected = select_vehicles(config_.vehicles, info.vehicle_names);
    for (std::size_t i = 0; i < selected.size(); ++i) {
      if (!selected[i]) continue;
      const std::string folder = "csv/" + info.vehicle_names[i] + "/";
      std::vector<Topic> topics = vehicle_topics(info.airframes[i]->num_rotors());
      for (const Series* series : info.series) topics.push_back(series_topic(*series));
      for (Topic& topic : topics) add(static_cast<VehicleId>(i), std::move(topic), info.directory, folder);
    }
    for (OpenTable& open : tables_) open.table.open();
    // Tables of the whole run; a file is created with its first row.
    for (const Series* series : info.series) add(kNoVehicle, series_topic(*series), info.directory, "csv/");
  }

  void write(const TickView& tick) override {
    const bool sample_due = gate_.due(tick.t);
    for (OpenTable& open : tables_) {
      if (!open.topic.sampled || sample_due) open.topic.write({tick, open.vehicle, *row_, open.table});
    }
  }

  std::vector<std::filesystem::path> finish() override {
    std::vector<std::filesystem::path> paths;
    for (OpenTable& open : tables_) {
      if (auto path = open.table.finish()) paths.push_back(std::move(*path));
    }
    return paths;
  }

 private:
  struct OpenTable {
    VehicleId vehicle;
    Topic topic;
    Table table;
  };

  void add(VehicleId vehicle, Topic topic, const std::filesystem::path& directory, const std::string& folder) {
    if (config_.topics.empty() || !selects(config_.topics, topic.name)) return;
    Table table(directory, folder + topic.name + ".csv", topic.columns);
    tables_.push_back({vehicle, std::move(topic), std::move(table)});
  }

  CsvConfig config_;
  RateGate gate_;
  std::vector<OpenTable> tables_;
  std::optional<CsvRow> row_;
};

/// Removes the tables of messages, which the description of `topics` summarizes as message_KIND.
std::vector<std::string> without_message_tables(std::vector<std::string> names) {
  std::erase_if(names, [](const std::string& name) { return name.starts_with("message_"); });
  return names;
}

}  // namespace

std::vector<TableType> csv_tables() {
  std::vector<TableType> tables;
  for (Topic& topic : vehicle_topics(1)) tables.push_back({std::move(topic.name), std::move(topic.columns)});
  for (TableType& series : series_types()) tables.push_back(std::move(series));
  return tables;
}

void CsvConfig::visit(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles to write; empty: all");
  v.field("rate_hz", rate_hz, "[Hz] rows of the topic state per second; 0: every tick", Range::between(0.0, 1e5));
  v.check(rate_hz == 0.0 || rate_hz >= 1e-3, "rate_hz", "0, or at least 0.001");
  static const std::vector<std::string> names = csv_topic_names();
  static const std::string doc =
      "[-] tables to write: " + listed(without_message_tables(names)) + ", and message_KIND of each kind of message";
  v.field("topics", topics, doc.c_str());
  const bool known = std::all_of(topics.begin(), topics.end(), [](const std::string& topic) {
    return std::find(names.begin(), names.end(), topic) != names.end();
  });
  v.check(known, "topics", "a list of " + listed(names));
}

std::unique_ptr<Recorder> make_csv_recorder(const ModuleConfig& config) {
  return std::make_unique<CsvRecorder>(dynamic_cast<const CsvConfig&>(config));
}

}  // namespace swiftlet::sim
