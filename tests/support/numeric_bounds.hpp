// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/scenario/units.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::testing {

/// Visits a configuration and records its numeric keys with their ranges, and the registries of its modules.
class NumericKeys : public ConfigVisitor {
 public:
  struct Key {
    std::string path;  ///< "vehicles[].start.yaw_deg"
    Range range;
    bool whole = false;
    int copies = 0;       ///< number of list elements that all have the value; 0: a number, not a list
    bool nested = false;  ///< the list is the only element of another list
  };

  std::vector<Key> keys;
  std::vector<std::span<const ModuleType>> registries;

  using ConfigVisitor::choice;
  void field(const char*, bool&, const char*) override {}
  void field(const char* key, int&, const char*, Range range) override { note(key, range, true); }
  void field(const char*, std::uint64_t&, const char*) override {}
  void field(const char* key, double&, const char*, Range range) override { note(key, range, false); }
  void field(const char*, std::string&, const char*) override {}
  void field(const char* key, Eigen::Vector2d&, const char*, Range range) override { note(key, range, false, 2); }
  void field(const char* key, Eigen::Vector3d&, const char*, Range range) override { note(key, range, false, 3); }
  void field(const char* key, std::vector<double>&, const char*, Range range) override { note(key, range, false, 1); }
  void field(const char*, std::vector<std::string>&, const char*) override {}
  void field(const char* key, std::vector<Eigen::Vector3d>&, const char*, Range range) override {
    note(key, range, false, 3, true);
  }
  void choice(const char*, std::string&, std::span<const char* const>, const char*) override {}
  void file(const char*, std::string&, const char*) override {}
  void model(const char*, std::string&, const char*, const char*) override {}
  void module(const char*, Module&, std::span<const ModuleType> types, const char*) override {
    registries.push_back(types);
  }
  void modules(const char*, std::vector<Module>&, std::span<const ModuleType> types, const char*) override {
    registries.push_back(types);
  }
  void check(bool, const char*, const std::string&) override {}

 protected:
  bool begin_object(const char* key, const char*) override {
    prefixes_.push_back(prefix_);
    prefix_ += std::string(key) + ".";
    return true;
  }
  void end_object() override {
    prefix_ = prefixes_.back();
    prefixes_.pop_back();
  }
  bool begin_list(const char* key, std::size_t& size, const char* doc) override {
    size = std::min<std::size_t>(size, 1);
    return begin_object((std::string(key) + "[]").c_str(), doc);
  }
  void begin_element(std::size_t) override {}
  void end_element() override {}
  void end_list() override { end_object(); }
  bool wants_example() const override { return true; }

 private:
  void note(const char* key, const Range& range, bool whole, int copies = 0, bool nested = false) {
    keys.push_back({prefix_ + key, range, whole, copies, nested});
  }

  std::string prefix_;
  std::vector<std::string> prefixes_;
};

/// Does the reader reject this value of the key for its range? Other errors are ignored.
inline bool is_refused(const NumericKeys::Key& key, double value, const sim::ConfigVisit& visit) {
  std::string text, ends, shown;
  std::string_view rest = key.path;
  while (true) {
    const std::size_t dot = std::min(rest.find('.'), rest.size());
    std::string_view part = rest.substr(0, dot);
    const bool in_list = part.ends_with("[]");
    if (in_list) part.remove_suffix(2);
    text += (text.empty() ? "" : "{") + std::string(part) + ": " + (in_list ? "[" : "");
    ends.insert(0, std::string(in_list ? "]" : "") + (shown.empty() ? "" : "}"));
    shown += (shown.empty() ? "" : ".") + std::string(part) + (in_list ? "[0]" : "");
    if (dot == rest.size()) break;
    rest.remove_prefix(dot + 1);
  }
  std::string given = sim::yaml_number(value);
  for (int i = 1; i < key.copies; ++i) given += ", " + sim::yaml_number(value);
  if (key.copies > 0) given = "[" + given + "]";
  if (key.nested) given = "[" + given + "]";
  text += given + ends;
  try {
    sim::read_config_text(text + "\n", "bounds.yaml", visit);
    return false;
  } catch (const sim::InputError& problem) {
    const std::string message = problem.what();
    const std::size_t at = message.find(": " + shown);
    if (at == std::string::npos) return false;
    const std::size_t end = message.find_first_not_of("[]0123456789", at + 2 + shown.size());
    std::string_view complaint = std::string_view(message).substr(std::min(end, message.size()));
    for (const std::string_view words : {": expected a number", ": expected a whole number"}) {
      if (!complaint.starts_with(words)) continue;
      complaint.remove_prefix(words.size());
      for (const char* range : {" in ", " > ", " >= ", " < ", " <= ", ","}) {
        if (complaint.starts_with(range)) return true;
      }
    }
    return false;
  }
}

/// Appends one line for each wrong end of a range: a bound that is rejected, or a value beyond it that is accepted.
inline void append_wrong_bounds(const NumericKeys::Key& key, const sim::ConfigVisit& visit,
                                std::vector<std::string>& wrong) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity(), kBillion = 1e9;
  const auto try_end = [&](double end, bool excluded, double outward) {
    const auto next = [&](double towards) {
      return key.whole ? end + (towards > 0.0 ? 1.0 : -1.0) : std::nextafter(end, towards * kInfinity);
    };
    const double inside = excluded ? next(-outward) : end, outside = excluded ? end : next(outward);
    if (is_refused(key, inside, visit)) wrong.push_back(key.path + ": refuses " + sim::yaml_number(inside));
    if (!is_refused(key, outside, visit)) wrong.push_back(key.path + ": takes " + sim::yaml_number(outside));
  };
  const double least = key.whole ? std::numeric_limits<int>::min() : -kBillion;
  const double most = key.whole ? std::numeric_limits<int>::max() : std::max(kBillion, key.range.min);
  const bool is_below = std::isfinite(key.range.min), is_above = std::isfinite(key.range.max);
  try_end(is_below ? key.range.min : least, is_below && key.range.min_excluded, -1.0);
  try_end(is_above ? key.range.max : most, is_above && key.range.max_excluded, 1.0);
}

/// Checks every end of every range of a configuration and of its modules, each registry once. Empty when all are right.
/// @param visit  visits a fresh configuration at each call
inline std::vector<std::string> wrong_bounds(const sim::ConfigVisit& visit, std::size_t& num_keys) {
  std::vector<std::string> wrong;
  std::vector<std::span<const ModuleType>> registries;
  std::set<const ModuleType*> known;
  const auto test = [&](const sim::ConfigVisit& one) {
    NumericKeys numeric;
    one(numeric);
    for (const NumericKeys::Key& key : numeric.keys) append_wrong_bounds(key, one, wrong);
    num_keys += numeric.keys.size();
    for (const auto& types : numeric.registries) {
      if (known.insert(types.data()).second) registries.push_back(types);
    }
  };
  test(visit);
  for (std::size_t i = 0; i < registries.size(); ++i) {
    const auto types = registries[i];
    for (const ModuleType& type : types) test([&](ConfigVisitor& v) { type.make_config()->visit(v); });
  }
  return wrong;
}

}  // namespace swiftlet::testing
