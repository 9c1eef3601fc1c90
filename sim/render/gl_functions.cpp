// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/gl_functions_internal.hpp"

#include <stdexcept>
#include <string>

#include "sim/render/gl_context.hpp"

namespace swiftlet::sim {
namespace {

template <class Function>
void load(Function& function, const char* name) {
  function = reinterpret_cast<Function>(GlContext::proc_address(name));
  if (function == nullptr) throw std::runtime_error(std::string("pictures: this OpenGL has no ") + name);
}

}  // namespace

GlFunctions load_gl_functions() {
  GlFunctions gl;
#define SWIFTLET_GL_LOAD(type, name) load(gl.name, "gl" #name);
  SWIFTLET_GL_FUNCTIONS(SWIFTLET_GL_LOAD)
#undef SWIFTLET_GL_LOAD
  return gl;
}

}  // namespace swiftlet::sim
