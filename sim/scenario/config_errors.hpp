// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// Errors of one configuration, collected so that one message names all of them.
class ConfigErrors {
 public:
  /// @param root  place of the configuration, whose errors are reported before those of other files
  explicit ConfigErrors(const Place& root) : root_(root) {}

  bool empty() const { return errors_.empty(); }
  void add(const Place& place, const std::string& path, const std::string& message);
  /// Adds "expected ..., found ..." for the value of a key.
  void add_value(const Node& node, const std::string& path, const std::string& expected, const std::string& hint = "");
  /// Runs an action and adds its InputError.
  template <class Action>
  void attempt(const Place& place, const Action& action) {
    try {
      action();
    } catch (const InputError& problem) {
      add_once(problem.what(), place, problem.what());
    }
  }
  /// Throws the errors, if any, in the order of the text, followed by those of other files.
  void report();

 private:
  struct Error {
    Place place;
    std::string line;
  };
  void add_once(const std::string& identity, const Place& place, std::string line);

  Place root_;
  std::vector<Error> errors_;
  std::set<std::string> identities_;  // an error in an asset that is used twice has one
};

}  // namespace swiftlet::sim
