// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>

#include "sim/render/gl_functions_internal.hpp"

namespace swiftlet::sim {

// Handles of GL objects without destructors: the objects live until their context is destroyed.

class Program {
 public:
  Program() = default;
  /// Throws std::logic_error with the compiler's log.
  Program(const GlFunctions& gl, const char* name, std::string_view vertex_source, std::string_view fragment_source);

  void use() const { gl_->UseProgram(id_); }
  // For the program in use:
  void set(const char* name, float value) const { gl_->Uniform1f(location(name), value); }
  void set(const char* name, int value) const { gl_->Uniform1i(location(name), value); }
  void set(const char* name, const Eigen::Vector2f& value) const {
    gl_->Uniform2f(location(name), value.x(), value.y());
  }
  void set(const char* name, const Eigen::Vector3f& value) const {
    gl_->Uniform3f(location(name), value.x(), value.y(), value.z());
  }
  void set(const char* name, const Eigen::Vector4f& value) const {
    gl_->Uniform4f(location(name), value.x(), value.y(), value.z(), value.w());
  }
  void set(const char* name, const Eigen::Matrix4f& m) const {
    gl_->UniformMatrix4fv(location(name), 1, GL_FALSE, m.data());
  }
  GLint location(const char* name) const { return gl_->GetUniformLocation(id_, name); }

 private:
  const GlFunctions* gl_ = nullptr;
  GLuint id_ = 0;
};

/// A framebuffer with textures for up to two colors and depth (0: none).
struct Target {
  GLuint framebuffer = 0;
  GLuint color = 0;
  GLuint color2 = 0;
  GLuint depth = 0;
  int width = 0;
  int height = 0;
};

struct TargetFormat {
  GLenum color = 0;  ///< such as GL_RGBA8; 0: none
  GLenum depth = 0;  ///< such as GL_DEPTH_COMPONENT32F; 0: none
  int samples = 1;
  bool two_colors = false;  ///< a second color texture of the same format
  bool compare = false;     ///< depth is sampled as a shadow map: less or equal passes, bilinear, lit outside
};

Target make_target(const GlFunctions& gl, int width, int height, const TargetFormat& format);
void delete_target(const GlFunctions& gl, Target& target);

/// A vertex array object with its own buffer.
struct VertexBuffer {
  GLuint array = 0;
  GLuint buffer = 0;
};
VertexBuffer make_vertex_buffer(const GlFunctions& gl);
GLuint make_buffer(const GlFunctions& gl, GLenum target, const void* data, std::size_t bytes);
/// Sets attribute `index` of the bound array and buffer: `count` floats at `offset`.
void float_attribute(const GlFunctions& gl, GLuint index, int count, std::size_t stride, std::size_t offset,
                     GLuint divisor = 0);

}  // namespace swiftlet::sim
