// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/bindings.hpp"
#include "sim/python/fields.hpp"
#include "swiftlet/sim/run/version.hpp"

namespace swiftlet::python {
namespace {

// The library is built for processors with AVX2; others would stop with an illegal instruction.
void require_known_processor() {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2"))
    throw py::import_error("swiftlet: expected a processor with AVX2, found one without");
#endif
}

}  // namespace
}  // namespace swiftlet::python

PYBIND11_MODULE(_core, module) {
  using namespace swiftlet;
  python::require_known_processor();
  module.doc() = "The compiled part of swiftlet.";
  module.attr("version") = sim::version();
  module.attr("git_revision") = sim::git_revision();
  python::bind_errors(module);
  python::bind_table(module);
  python::bind_scenario(module);
  python::bind_scan(module);
  python::bind_make_scan(module);
  python::bind_modules(module);
  python::bind_simulator(module);
  python::bind_onboard(module);
  python::bind_functions(module);
}
