// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of the configuration reader. Any bytes must end in a configuration or in an InputError of good form, and
// what was read must survive being written and read again. Files exist in memory only.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"
#include "tests/sim/scenario/example_config.hpp"

namespace swiftlet::sim {
namespace {

void require(bool ok, const char* what, const std::string& text) {
  if (ok) return;
  std::fprintf(stderr, "%s:\n%s\n", what, text.c_str());
  std::abort();
}

FleetConfig read(const std::string& text, const Overrides& overrides) {
  static const MemoryFiles files = example_files();
  FleetConfig fleet;
  read_config_text(
      text, "/in/fuzz.yaml", [&](ConfigVisitor& v) { fleet.visit(v); }, overrides, files);
  return fleet;
}

std::string write(FleetConfig fleet) {
  return write_config([&](ConfigVisitor& v) { fleet.visit(v); });
}

/// Lines "--set path=value" at the head of the input are overrides; the rest is the file.
Overrides split_overrides(std::string& text) {
  Overrides overrides;
  while (text.starts_with("--set ") && overrides.size() < 4) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::size_t equals = std::min(text.find('='), end);
    overrides.emplace_back(text.substr(6, equals - 6), equals < end ? text.substr(equals + 1, end - equals - 1) : "");
    text.erase(0, std::min(end + 1, text.size()));
  }
  return overrides;
}

void check_message(const std::string& message) {
  require(!message.empty() && message.size() < 200'000, "message of odd size", message);
  for (const char c : message) {
    require(static_cast<unsigned char>(c) >= 0x20 || c == '\n', "control character in a message", message);
  }
  require(message.find("expected") != std::string::npos || message.find("cannot be read") != std::string::npos,
          "message that says nothing", message);
}

void run(std::string text) {
  const Overrides overrides = split_overrides(text);
  std::string written;
  try {
    written = write(read(text, overrides));
  } catch (const InputError& problem) {
    check_message(problem.what());
    return;
  }
  try {
    require(write(read(written, {})) == written, "changed by writing and reading", written);
  } catch (const InputError& problem) {
    require(false, problem.what(), written);
  }
}

}  // namespace
}  // namespace swiftlet::sim

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  swiftlet::sim::run(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
