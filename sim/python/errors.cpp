// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/errors/errors.hpp"

#include <exception>
#include <stdexcept>

#include "sim/python/bindings.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet::python {

void bind_errors(py::module_& module) {
  static py::exception<sim::InputError> input_error(module, "InputError", PyExc_ValueError);
  static py::exception<ContractViolation> internal_error(module, "InternalError", PyExc_RuntimeError);
  input_error.attr("__doc__") = "The input is invalid. The message names file, line and key, as that of the program.";
  internal_error.attr("__doc__") = "An error of the library, not of its input.";
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const sim::InputError& error) {
      input_error(error.what());
    } catch (const ContractViolation& error) {
      internal_error(error.what());
    } catch (const sim::OutOfMemory& error) {
      PyErr_SetString(PyExc_MemoryError, error.what());
    }
  });
  // A wrong type within an argument is a TypeError, like that of the argument itself.
  py::register_local_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const py::cast_error& error) {
      PyErr_SetString(PyExc_TypeError, error.what());
    }
  });
}

}  // namespace swiftlet::python
