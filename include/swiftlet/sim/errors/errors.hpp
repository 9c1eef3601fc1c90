// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <new>
#include <stdexcept>
#include <string>

namespace swiftlet::sim {

/// Invalid user input; programs exit with status 2. what() is one line:
/// "file:line:column: key: expected ..., found ...; did you mean ...".
class InputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The machine has less memory than the run needs. what() is one line that names the consumer.
class OutOfMemory : public std::bad_alloc {
 public:
  explicit OutOfMemory(const std::string& at) : what_("out of memory " + at) {}
  const char* what() const noexcept override { return what_.c_str(); }

 private:
  std::string what_;
};

}  // namespace swiftlet::sim
