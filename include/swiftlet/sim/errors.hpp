// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <new>
#include <stdexcept>
#include <string>

namespace swiftlet::sim {

/// The user's input is wrong; programs answer with exit status 2. what() is one line:
/// "file:line:column: key: expected ..., found ...; did you mean ...".
class InputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The machine has less memory than the run takes. what() tells at what, as one line.
class OutOfMemory : public std::bad_alloc {
 public:
  explicit OutOfMemory(const std::string& at) : what_("out of memory " + at) {}
  const char* what() const noexcept override { return what_.c_str(); }

 private:
  std::string what_;
};

}  // namespace swiftlet::sim
