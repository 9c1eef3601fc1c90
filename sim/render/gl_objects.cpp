// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/gl_objects_internal.hpp"

#include <stdexcept>
#include <string>

namespace swiftlet::sim {
namespace {

GLuint compile(const GlFunctions& gl, const char* name, GLenum stage, std::string_view source) {
  const GLuint shader = gl.CreateShader(stage);
  const char* text = source.data();
  const auto size = static_cast<GLint>(source.size());
  gl.ShaderSource(shader, 1, &text, &size);
  gl.CompileShader(shader);
  GLint ok = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  throw std::logic_error(std::string("shader ") + name + ": " + log);
}

GLuint make_texture(const GlFunctions& gl, int width, int height, GLenum format, int samples) {
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  if (samples > 1) {
    gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, texture);
    gl.TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, samples, format, width, height, GL_TRUE);
    return texture;
  }
  const bool depth = format == GL_DEPTH_COMPONENT16 || format == GL_DEPTH_COMPONENT32F;
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0, depth ? GL_DEPTH_COMPONENT : GL_RGBA,
                depth ? GL_FLOAT : GL_UNSIGNED_BYTE, nullptr);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

}  // namespace

Program::Program(const GlFunctions& gl, const char* name, std::string_view vertex_source,
                 std::string_view fragment_source)
    : gl_(&gl), id_(gl.CreateProgram()) {
  const GLuint stages[] = {compile(gl, name, GL_VERTEX_SHADER, vertex_source),
                           compile(gl, name, GL_FRAGMENT_SHADER, fragment_source)};
  for (const GLuint stage : stages) gl.AttachShader(id_, stage);
  gl.LinkProgram(id_);
  for (const GLuint stage : stages) gl.DeleteShader(stage);
  GLint ok = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return;
  std::string log(4096, '\0');
  GLsizei length = 0;
  gl.GetProgramInfoLog(id_, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  throw std::logic_error(std::string("shader ") + name + ": " + log);
}

Target make_target(const GlFunctions& gl, int width, int height, const TargetFormat& format) {
  Target target;
  target.width = width;
  target.height = height;
  const GLenum kind = format.samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
  gl.GenFramebuffers(1, &target.framebuffer);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  if (format.color != 0) {
    target.color = make_texture(gl, width, height, format.color, format.samples);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, kind, target.color, 0);
    if (format.two_colors) {
      target.color2 = make_texture(gl, width, height, format.color, format.samples);
      gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, kind, target.color2, 0);
    }
  } else {
    gl.DrawBuffer(GL_NONE);
    gl.ReadBuffer(GL_NONE);
  }
  if (format.depth != 0) {
    target.depth = make_texture(gl, width, height, format.depth, format.samples);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, kind, target.depth, 0);
  }
  if (format.compare) {
    const float lit[] = {1.0F, 1.0F, 1.0F, 1.0F};
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    gl.TexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, lit);
  }
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("pictures: OpenGL cannot draw " + std::to_string(width) + " x " + std::to_string(height) +
                             " pixels with " + std::to_string(format.samples) + " samples");
  }
  return target;
}

void delete_target(const GlFunctions& gl, Target& target) {
  gl.DeleteFramebuffers(1, &target.framebuffer);
  gl.DeleteTextures(1, &target.color);
  gl.DeleteTextures(1, &target.color2);
  gl.DeleteTextures(1, &target.depth);
  target = {};
}

VertexBuffer make_vertex_buffer(const GlFunctions& gl) {
  VertexBuffer made;
  gl.GenVertexArrays(1, &made.array);
  gl.BindVertexArray(made.array);
  gl.GenBuffers(1, &made.buffer);
  gl.BindBuffer(GL_ARRAY_BUFFER, made.buffer);
  return made;
}

GLuint make_buffer(const GlFunctions& gl, GLenum target, const void* data, std::size_t bytes) {
  GLuint buffer = 0;
  gl.GenBuffers(1, &buffer);
  gl.BindBuffer(target, buffer);
  gl.BufferData(target, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
  return buffer;
}

void float_attribute(const GlFunctions& gl, GLuint index, int count, std::size_t stride, std::size_t offset,
                     GLuint divisor) {
  gl.EnableVertexAttribArray(index);
  gl.VertexAttribPointer(index, count, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                         reinterpret_cast<const void*>(offset));
  gl.VertexAttribDivisor(index, divisor);
}

}  // namespace swiftlet::sim
