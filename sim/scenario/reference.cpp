// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/reference.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/sim/recorders/csv.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

/// A position in the configuration where a module is chosen by name.
struct Choice {
  std::string path;
  std::string doc;
  std::span<const ModuleType> types;
};

std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

std::string code(const std::string& text) { return text.empty() ? "" : "`" + text + "`"; }

/// Splits "[m] meaning" into unit and meaning.
std::pair<std::string_view, std::string_view> unit_and_meaning(std::string_view doc) {
  const std::size_t end = doc.starts_with('[') ? doc.find(']') : std::string_view::npos;
  if (end == std::string_view::npos) return {{}, doc};
  const std::string_view unit = doc.substr(1, end - 1);
  doc.remove_prefix(std::min(end + 2, doc.size()));
  return {unit == "-" ? std::string_view() : unit, doc};
}

std::string range_text(const Range& range) {
  const bool below = std::isfinite(range.min), above = std::isfinite(range.max);
  const std::string least = (range.min_excluded ? "> " : ">= ") + yaml_number(range.min);
  const std::string most = (range.max_excluded ? "< " : "<= ") + yaml_number(range.max);
  if (below && above && !range.min_excluded && !range.max_excluded) {
    return yaml_number(range.min) + " to " + yaml_number(range.max);
  }
  return below && above ? least + ", " + most : below ? least : above ? most : "";
}

template <class Values, class ToText>
std::string list_text(const Values& values, const ToText& to_text) {
  constexpr std::size_t kMaxShown = 6;
  std::string text;
  std::size_t count = 0;
  for (const auto& value : values) {
    if (count++ == kMaxShown) return "[" + text + ", ...]";
    text += (text.empty() ? "" : ", ") + to_text(value);
  }
  return "[" + text + "]";
}

std::string vector_text(const Eigen::Vector3d& value) { return list_text(value, yaml_number); }

/// Writes one table; modules are collected instead of entered.
class TableVisitor final : public ConfigVisitor {
 public:
  explicit TableVisitor(std::string root) : root_(std::move(root)) {}

  std::string take_rows() { return std::move(rows_); }
  std::vector<Choice> take_choices() { return std::move(choices_); }

  void field(const char* key, bool& value, const char* doc) override {
    row(key, "true or false", value ? "true" : "false", "", doc);
  }
  void field(const char* key, int& value, const char* doc, Range range) override {
    row(key, "whole number", std::to_string(value), range_text(range), doc);
  }
  void field(const char* key, std::uint64_t& value, const char* doc) override {
    row(key, "whole number", std::to_string(value), ">= 0", doc);
  }
  void field(const char* key, double& value, const char* doc, Range range) override {
    row(key, "number", yaml_number(value), range_text(range), doc);
  }
  void field(const char* key, std::string& value, const char* doc) override { row(key, "text", text(value), "", doc); }
  void field(const char* key, Eigen::Vector2d& value, const char* doc, Range range) override {
    row(key, "2 numbers", list_text(value, yaml_number), range_text(range), doc);
  }
  void field(const char* key, Eigen::Vector3d& value, const char* doc, Range range) override {
    row(key, "3 numbers", vector_text(value), range_text(range), doc);
  }
  void field(const char* key, std::vector<double>& value, const char* doc, Range range) override {
    row(key, "list of numbers", list_text(value, yaml_number), range_text(range), doc);
  }
  void field(const char* key, std::vector<std::string>& value, const char* doc) override {
    row(key, "list of texts", list_text(value, text), "", doc);
  }
  void field(const char* key, std::vector<Eigen::Vector3d>& value, const char* doc, Range range) override {
    row(key, "list of 3 numbers each", list_text(value, vector_text), range_text(range), doc);
  }
  void choice(const char* key, std::string& value, std::span<const char* const> words, const char* doc) override {
    std::string range;
    for (const char* word : words) range += (range.empty() ? "" : ", ") + code(word);
    row(key, "choice", text(value), range, doc);
  }
  void file(const char* key, std::string& path, const char* doc) override {
    row(key, "file", text(path), "an existing file", doc);
  }
  void model(const char* key, std::string& name, const char* folder, const char* doc) override {
    row(key, "asset", text(name), "`assets/" + std::string(folder) + "/*.yaml` or a path", doc);
  }
  void changes(const char* key, ConfigChanges&, const char* doc) override { row(key, "map of keys", "{}", "", doc); }
  void module(const char* key, Module& value, std::span<const ModuleType> types, const char* doc) override {
    add_choice(key, "module", value.type, types, doc);
  }
  void modules(const char* key, std::vector<Module>& values, std::span<const ModuleType> types,
               const char* doc) override {
    const auto type_of = [](const Module& module) { return module.type; };
    add_choice(key, "list of modules", list_text(values, type_of), types, doc);
  }
  void check(bool, const char*, const std::string&) override {}

 protected:
  bool begin_object(const char* key, const char*) override {
    path_.push_back(path_.empty() ? key : path_.back() + "." + key);
    return true;
  }
  void end_object() override { path_.pop_back(); }

  bool begin_list(const char* key, std::size_t& size, const char* doc) override {
    row(key, "list of maps", size == 0 ? "[]" : std::to_string(size) + (size == 1 ? " element" : " elements"), "", doc);
    path_.push_back((path_.empty() ? "" : path_.back() + ".") + key + "[]");
    return true;
  }
  void begin_element(std::size_t index) override { hidden_ += index > 0 ? 1 : 0; }
  // Only the first element is shown, so an end belongs to a hidden one as long as any is open.
  void end_element() override { hidden_ -= hidden_ > 0 ? 1 : 0; }
  void end_list() override { path_.pop_back(); }
  bool wants_example() const override { return true; }

 private:
  static std::string text(const std::string& value) { return value.empty() ? "\"\"" : value; }

  std::string full_key(const char* key) const { return path_.empty() ? key : path_.back() + "." + key; }

  void row(const char* key, const std::string& type, const std::string& value, const std::string& range,
           std::string_view doc) {
    if (hidden_ > 0) return;
    const auto [unit, meaning] = unit_and_meaning(doc);
    rows_ += "| " + code(full_key(key)) + " | " + type + " | " + cell(code(value)) + " | " + cell(unit) + " | " +
             cell(range) + " | " + cell(meaning) + " |\n";
  }

  void add_choice(const char* key, const std::string& kind, const std::string& value, std::span<const ModuleType> types,
                  const char* doc) {
    std::string range;
    for (const ModuleType& type : types) range += (range.empty() ? "" : ", ") + code(type.name);
    row(key, kind, value, range, doc);
    if (hidden_ == 0) choices_.push_back({(root_.empty() ? "" : root_ + ".") + full_key(key), doc, types});
  }

  std::string root_;  ///< path of the module described by the table
  std::string rows_;
  std::vector<Choice> choices_;
  std::vector<std::string> path_;
  int hidden_ = 0;  ///< number of open hidden list elements
};

std::string table(const std::string& rows) {
  if (rows.empty()) return "No keys of its own.\n";
  return "| key | type | default | unit | range | meaning |\n| --- | --- | --- | --- | --- | --- |\n" + rows;
}

/// A row for each column.
std::string columns_table(std::span<const Column> columns) {
  std::string text = "| columns | unit | meaning |\n| --- | --- | --- |\n";
  for (std::size_t i = 0, end = 0; i < columns.size(); i = end) {
    std::string names;
    for (end = i; end < columns.size() && columns[end].doc == columns[i].doc; ++end) {
      names += (names.empty() ? "" : " ") + code(columns[end].name);
    }
    const auto [unit, meaning] = unit_and_meaning(columns[i].doc);
    text += "| " + names + " | " + cell(unit) + " | " + cell(meaning) + " |\n";
  }
  return text;
}

std::string data_tables() {
  sensor_registry();  // its rows register tables
  std::string text =
      "\n## Tables\n\nThe tables of the recorder `csv`. ROS messages without a standard type have a "
      "field for each column.\n";
  for (const TableType& table : csv_tables()) {
    text += "\n### `" + table.name + "`\n\n" + columns_table(table.columns);
  }
  text += "\n## Messages\n\nMessages between vehicles. Sizes are those on the air, with a header of " +
          std::to_string(Message::kHeaderBytes) + " bytes and the name of the topic.\n";
  for (const MessageKind& kind : message_kinds()) {
    text += "\n### `" + std::string(kind.topic) + "`\n\n" + kind.doc + "; version " + std::to_string(kind.version) +
            ", " + std::to_string(kind.size_bytes()) + " bytes.\n\n" + columns_table(kind.columns());
  }
  return text;
}

std::string without_unit(const std::string& doc) { return doc.starts_with("[-] ") ? doc.substr(4) : doc; }

}  // namespace

std::string reference_tables(const ConfigVisit& visit, const std::string& title) {
  TableVisitor own("");
  visit(own);
  std::string text = "## " + title + "\n\n" + table(own.take_rows());
  const std::vector<Choice> first = own.take_choices();
  std::deque<Choice> waiting(first.begin(), first.end());
  std::vector<const ModuleType*> done;
  for (; !waiting.empty(); waiting.pop_front()) {
    const Choice choice = waiting.front();
    // Several keys may use the same registry.
    if (std::find(done.begin(), done.end(), choice.types.data()) != done.end()) continue;
    done.push_back(choice.types.data());
    text += "\n## `" + choice.path + "`\n\n" + without_unit(choice.doc) + "\n";
    for (const ModuleType& type : choice.types) {
      TableVisitor visitor(choice.path);
      type.make_config()->visit(visitor);
      text += "\n### `type: " + std::string(type.name) + "`\n\n" + type.doc + "\n\n" + table(visitor.take_rows());
      for (Choice& nested : visitor.take_choices()) waiting.push_back(std::move(nested));
    }
  }
  return text;
}

std::string write_reference() {
  Scenario scenario;
  return "# Configuration reference\n\n"
         "Every key of a scenario with its default. This page is generated: `swiftlet reference > "
         "docs/reference.md`.\n\n"
         "A key's suffix is its unit (`_m`, `_s`, `_hz`, `_deg` ...). A value may be written in another unit of the "
         "same\n"
         "kind: `range_max_m: 20 cm`, `delay_s: 300 ms`. A module without keys may be written by its name alone:\n"
         "`localization: ground_truth`.\n\n"
         "`base: FILE` lays a scenario on another one. Maps merge, anything else is replaced, and a map whose `type`\n"
         "changes starts afresh. `vehicles[0]: {...}`, `vehicles[uav1]: {...}` and `vehicles[*]: {...}` change "
         "elements\n"
         "of a list, and `vehicles[uav*]: {...}` all whose names begin so. `--set vehicles[0].start.yaw_deg=90` does "
         "the same from the command line.\n\n"
         "[scenarios.md](scenarios.md) explains anchors, merge keys (`<<`), and several vehicles from one entry "
         "(`count`).\n\n" +
         reference_tables([&](ConfigVisitor& v) { scenario.visit(v); }, "Scenario") + data_tables();
}

}  // namespace swiftlet::sim
