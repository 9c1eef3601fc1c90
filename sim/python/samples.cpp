// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/samples.hpp"

#include <bit>
#include <limits>

#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::python {
namespace {

/// Rows of a data type unknown at compile time: an eight-byte cell for each number, and texts.
struct Rows {
  std::vector<Field> fields;
  std::vector<std::uint64_t> cells;
  std::vector<std::string> texts;  // a cell holds the index
};

class RowWriter final : public ColumnSink {
 public:
  explicit RowWriter(Rows& rows) : rows_(rows) {}

  void time(const ColumnName&, TimeNs t) override { rows_.cells.push_back(std::bit_cast<std::uint64_t>(t)); }
  void number(const ColumnName&, double value) override { rows_.cells.push_back(std::bit_cast<std::uint64_t>(value)); }
  void integer(const ColumnName& name, std::int64_t value) override { number(name, static_cast<double>(value)); }
  void flag(const ColumnName& name, bool value) override { number(name, value); }
  void text(const ColumnName&, std::string_view value) override {
    rows_.cells.push_back(rows_.texts.size());
    rows_.texts.emplace_back(value);
  }
  void vehicle(const ColumnName& name, VehicleId id) override { text(name, std::to_string(id)); }
  void missing(const ColumnName& name) override { number(name, std::numeric_limits<double>::quiet_NaN()); }

 private:
  Rows& rows_;
};

Table table_of(const SampleList& samples) {
  auto rows = std::make_shared<Rows>();
  RowWriter writer(*rows);
  for (std::size_t i = 0; i < samples.size(); ++i) samples.put(i, writer);
  for (const Column& column : samples.columns()) {
    Field field{column.name, column.doc, static_cast<std::ptrdiff_t>(8 * rows->fields.size()), "d", {}, {}, nullptr};
    if (column.type == Column::Type::kTime) {
      field.name = name_of_time(column.name);
      field.doc = "[ns]" + column.doc.substr(column.doc.find(']') + 1);
      field.format = "q";
    } else if (column.type == Column::Type::kText) {
      field.format = nullptr;
      field.read = [all = rows.get()](const std::byte* at) {
        return py::str(all->texts[*reinterpret_cast<const std::uint64_t*>(at)]);
      };
    }
    rows->fields.push_back(std::move(field));
  }
  return Table::of_cells(rows->fields, rows->cells, rows);
}

}  // namespace

Table samples_named(const Observation& observation, const std::string& kind) {
  std::optional<Table> found;
  Observation::each_samples(observation, [&]<class Sample>(const std::vector<Sample>& samples) {
    if (kind == Sample::kName) found = Table::copy_of(std::span<const Sample>(samples));
  });
  for (const auto& samples : observation.others) {
    if (kind == samples->name()) found = table_of(*samples);
  }
  if (!found) reject_kind(observation, kind);
  return *found;
}

void reject_kind(const Observation& observation, const std::string& kind) {
  std::vector<std::string> names;
  Observation::each_samples(observation,
                            [&]<class Sample>(const std::vector<Sample>&) { names.emplace_back(Sample::kName); });
  for (const auto& samples : observation.others) names.emplace_back(samples->name());
  throw py::key_error("expected " + sim::one_of(names) + ", found \"" + kind + "\"" + sim::did_you_mean(kind, names));
}

}  // namespace swiftlet::python
