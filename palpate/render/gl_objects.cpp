#include "palpate/render/gl_objects.h"

#include <epoxy/gl.h>

#include <stdexcept>
#include <utility>

namespace palpate::render {
namespace {

unsigned compile(GLenum kind, std::string_view name, std::string_view source) {
  const std::string text = "#version 330 core\n" + std::string(source);
  const char* pointer = text.c_str();
  const unsigned shader = glCreateShader(kind);
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (!good) {
    std::string log(4096, '\0');
    GLsizei length = 0;
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    glDeleteShader(shader);
    throw std::runtime_error("shader " + std::string(name) + ": " + log);
  }
  return shader;
}

struct GlFormat {
  GLint internal;
  GLenum format, type;
};
GlFormat gl_format(Format format) {
  switch (format) {
    case Format::r8:
      return {GL_R8, GL_RED, GL_UNSIGNED_BYTE};
    case Format::rg8:
      return {GL_RG8, GL_RG, GL_UNSIGNED_BYTE};
    case Format::rgb8:
      return {GL_RGB8, GL_RGB, GL_UNSIGNED_BYTE};
    case Format::rg32f:
      return {GL_RG32F, GL_RG, GL_FLOAT};
    case Format::rgba8:
      break;
  }
  return {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE};
}

}  // namespace

const char* const kFullScreen = R"(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

Program::Program(std::string_view name, std::string_view vertex, std::string_view fragment) {
  const unsigned v = compile(GL_VERTEX_SHADER, name, vertex);
  const unsigned f = compile(GL_FRAGMENT_SHADER, name, fragment);
  handle_ = glCreateProgram();
  glAttachShader(handle_, v);
  glAttachShader(handle_, f);
  glBindAttribLocation(handle_, 0, "position");
  glBindAttribLocation(handle_, 1, "normal");
  glBindAttribLocation(handle_, 2, "look");
  glLinkProgram(handle_);
  glDeleteShader(v);
  glDeleteShader(f);
  GLint good = 0;
  glGetProgramiv(handle_, GL_LINK_STATUS, &good);
  if (!good) {
    std::string log(4096, '\0');
    GLsizei length = 0;
    glGetProgramInfoLog(handle_, static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    glDeleteProgram(handle_);
    throw std::runtime_error("program " + std::string(name) + ": " + log);
  }
}
Program::~Program() { glDeleteProgram(handle_); }

Program& Program::use() {
  glUseProgram(handle_);
  return *this;
}

int Program::location(const char* name) {
  for (const auto& [known, place] : locations_) {
    if (known == name) return place;
  }
  const int place = glGetUniformLocation(handle_, name);
  locations_.emplace_back(name, place);
  return place;
}

Program& Program::set(const char* name, int value) {
  glUniform1i(location(name), value);
  return *this;
}
Program& Program::set(const char* name, float value) {
  glUniform1f(location(name), value);
  return *this;
}
Program& Program::set(const char* name, const Vector2f& value) {
  glUniform2fv(location(name), 1, value.data());
  return *this;
}
Program& Program::set(const char* name, const Vector3f& value) {
  glUniform3fv(location(name), 1, value.data());
  return *this;
}
Program& Program::set(const char* name, const Vector4f& value) {
  glUniform4fv(location(name), 1, value.data());
  return *this;
}
Program& Program::set(const char* name, const Matrix3f& value) {
  glUniformMatrix3fv(location(name), 1, GL_FALSE, value.data());
  return *this;
}
Program& Program::set(const char* name, const Matrix4f& value) {
  glUniformMatrix4fv(location(name), 1, GL_FALSE, value.data());
  return *this;
}
Program& Program::set(const char* name, const std::vector<Vector3f>& values) {
  glUniform3fv(location(name), static_cast<GLsizei>(values.size()), values.data()->data());
  return *this;
}
Program& Program::set(const char* name, const std::vector<Vector4f>& values) {
  glUniform4fv(location(name), static_cast<GLsizei>(values.size()), values.data()->data());
  return *this;
}

Texture::Texture(int width, int height, Format format, Filter filter)
    : width_(width), height_(height), format_(format) {
  glGenTextures(1, &handle_);
  glBindTexture(GL_TEXTURE_2D, handle_);
  const GLint wrap = filter == Filter::linear_repeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
  const GLint scaled = filter == Filter::nearest ? GL_NEAREST : GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, scaled);
  // Neither mipmaps nor anisotropic filtering: nothing needs them, and in software they are dear.
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, scaled);
  const auto [internal, external, type] = gl_format(format);
  glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, external, type, nullptr);
}
Texture::~Texture() {
  if (handle_ != 0) glDeleteTextures(1, &handle_);
}
Texture::Texture(Texture&& other) noexcept { *this = std::move(other); }
Texture& Texture::operator=(Texture&& other) noexcept {
  std::swap(handle_, other.handle_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  std::swap(format_, other.format_);
  return *this;
}

void Texture::upload(const void* pixels) {
  glBindTexture(GL_TEXTURE_2D, handle_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  const auto [internal, external, type] = gl_format(format_);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width_, height_, external, type, pixels);
}

void Texture::upload(const void* pixels, int stride, const std::array<int, 4>& box) {
  glBindTexture(GL_TEXTURE_2D, handle_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, stride);
  glPixelStorei(GL_UNPACK_SKIP_PIXELS, box[0]);
  glPixelStorei(GL_UNPACK_SKIP_ROWS, box[1]);
  const auto [internal, external, type] = gl_format(format_);
  glTexSubImage2D(GL_TEXTURE_2D, 0, box[0], box[1], box[2], box[3], external, type, pixels);
  for (const GLenum name : {GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS})
    glPixelStorei(name, 0);
}

void Texture::bind(int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, handle_);
}

Target::Target(int width, int height, Format format, bool depth, int samples)
    : colour_(width, height, format, Filter::linear), samples_(samples) {
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour_.handle(), 0);
  if (samples > 1) {
    glGenFramebuffers(1, &many_framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, many_framebuffer_);
    glGenTextures(1, &many_colour_);
    glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, many_colour_);
    glTexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, samples,
                            static_cast<GLenum>(gl_format(format).internal), width, height, GL_TRUE);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D_MULTISAMPLE, many_colour_, 0);
  }
  if (depth) {
    glGenRenderbuffers(1, &depth_);
    glBindRenderbuffer(GL_RENDERBUFFER, depth_);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, GL_DEPTH_COMPONENT24, width,
                                     height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  }
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    release();
    throw std::runtime_error("framebuffer " + std::to_string(width) + "x" + std::to_string(height) + ", " +
                             std::to_string(samples) + " samples: incomplete, status " +
                             std::to_string(status) +
                             "; the driver does not offer this size or sample count");
  }
}
void Target::release() {
  if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
  if (many_framebuffer_ != 0) glDeleteFramebuffers(1, &many_framebuffer_);
  if (many_colour_ != 0) glDeleteTextures(1, &many_colour_);
  if (depth_ != 0) glDeleteRenderbuffers(1, &depth_);
  framebuffer_ = many_framebuffer_ = many_colour_ = depth_ = 0;
}
Target::~Target() { release(); }
Target::Target(Target&& other) noexcept { *this = std::move(other); }
Target& Target::operator=(Target&& other) noexcept {
  std::swap(colour_, other.colour_);
  std::swap(framebuffer_, other.framebuffer_);
  std::swap(many_framebuffer_, other.many_framebuffer_);
  std::swap(many_colour_, other.many_colour_);
  std::swap(depth_, other.depth_);
  std::swap(samples_, other.samples_);
  return *this;
}

void Target::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, samples_ > 1 ? many_framebuffer_ : framebuffer_);
  glViewport(0, 0, width(), height());
}

void Target::bind_samples(int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, many_colour_);
}

void Target::resolve(int x, int y, int width, int height) const {
  if (samples_ <= 1 || width <= 0 || height <= 0) return;
  glDisable(GL_SCISSOR_TEST);  // a scissor would cut the copy too
  glBindFramebuffer(GL_READ_FRAMEBUFFER, many_framebuffer_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer_);
  glBlitFramebuffer(x, y, x + width, y + height, x, y, x + width, y + height, GL_COLOR_BUFFER_BIT,
                    GL_NEAREST);
}

void Target::read_rgb(std::vector<std::uint8_t>& rgb) const {
  rgb.resize(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()) * 3);
  read_rgb(rgb.data(), width());
}

void Target::read_rgb(std::uint8_t* rgb, int stride) const {
  read_rgb(rgb, stride, {0, 0, width(), height()});
}

void Target::read_rgb(std::uint8_t* rgb, int stride, const std::array<int, 4>& box) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ROW_LENGTH, stride);
  glReadPixels(box[0], box[1], box[2], box[3], GL_RGB, GL_UNSIGNED_BYTE,
               rgb + 3 * (static_cast<std::ptrdiff_t>(stride) * box[1] + box[0]));
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
}

void Target::read_rg(std::vector<std::uint8_t>& rg) const {
  rg.resize(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()) * 2);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width(), height(), GL_RG, GL_UNSIGNED_BYTE, rg.data());
}

FullScreen::FullScreen() { glGenVertexArrays(1, &array_); }
FullScreen::~FullScreen() { glDeleteVertexArrays(1, &array_); }
void FullScreen::draw() const {
  glBindVertexArray(array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace palpate::render
