// Shader programs, textures and framebuffers as values that free themselves.
//
// Handles are plain numbers so that OpenGL's headers stay inside the .cpp files. Rows: row 0 of a texture or
// target is row 0 (the top) of the picture; nothing is flipped anywhere. Thread: the context's. Wrong shaders
// throw.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::render {

using Matrix3f = Eigen::Matrix3f;
using Matrix4f = Eigen::Matrix4f;
using Vector2f = Eigen::Vector2f;
using Vector3f = Eigen::Vector3f;
using Vector4f = Eigen::Vector4f;

class Program {
 public:
  // Sources without the #version line. Throws std::runtime_error with the compiler's words.
  Program(std::string_view name, std::string_view vertex, std::string_view fragment);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  Program& use();
  // Values of uniforms; names the compiler has dropped are passed over. Call after use().
  Program& set(const char* name, int value);
  Program& set(const char* name, float value);
  Program& set(const char* name, const Vector2f& value);
  Program& set(const char* name, const Vector3f& value);
  Program& set(const char* name, const Vector4f& value);
  Program& set(const char* name, const Matrix3f& value);
  Program& set(const char* name, const Matrix4f& value);
  Program& set(const char* name, const std::vector<Vector3f>& values);
  Program& set(const char* name, const std::vector<Vector4f>& values);

 private:
  int location(const char* name);
  unsigned handle_ = 0;
  std::vector<std::pair<std::string, int>> locations_;
};

enum class Format { r8, rg8, rgb8, rgba8, rg32f };
enum class Filter { nearest, linear, linear_repeat };

class Texture {
 public:
  Texture() = default;
  Texture(int width, int height, Format format, Filter filter);
  ~Texture();
  Texture(Texture&& other) noexcept;
  Texture& operator=(Texture&& other) noexcept;

  // Bytes of r8, rg8, rgb8, rgba8 (rows packed), or floats of rg32f.
  void upload(const void* pixels);
  // The rectangle x, y, width, height of a picture that begins at `pixels` and whose rows are `stride` pixels apart.
  void upload(const void* pixels, int stride, const std::array<int, 4>& box);
  void bind(int unit) const;
  int width() const { return width_; }
  int height() const { return height_; }
  unsigned handle() const { return handle_; }
  explicit operator bool() const { return handle_ != 0; }

 private:
  unsigned handle_ = 0;
  int width_ = 0, height_ = 0;
  Format format_ = Format::rgba8;
};

// A place to draw into: colour as a texture, optionally depth; with samples > 1 it is resolved into the
// texture.
class Target {
 public:
  Target() = default;
  Target(int width, int height, Format format, bool depth, int samples = 1);
  ~Target();
  Target(Target&& other) noexcept;
  Target& operator=(Target&& other) noexcept;

  void bind() const;  // and sets the viewport to the whole of it
  // Of many samples: averages the rectangle, as it is encoded, into texture().
  void resolve(int x, int y, int width, int height) const;
  // Of many samples: they themselves, as a sampler2DMS.
  void bind_samples(int unit) const;
  int samples() const { return samples_; }
  const Texture& texture() const { return colour_; }
  int width() const { return colour_.width(); }
  int height() const { return colour_.height(); }
  // The whole picture as packed RGB bytes, row 0 first.
  void read_rgb(std::vector<std::uint8_t>& rgb) const;
  // The same into a part of a wider picture: `rgb` is where row 0 begins, rows are `stride` pixels apart.
  void read_rgb(std::uint8_t* rgb, int stride) const;
  // And of that one only the rectangle x, y, width, height.
  void read_rgb(std::uint8_t* rgb, int stride, const std::array<int, 4>& box) const;
  // Both channels of an rg8 one, rows packed.
  void read_rg(std::vector<std::uint8_t>& rg) const;
  explicit operator bool() const { return framebuffer_ != 0; }

 private:
  void release();
  Texture colour_;
  unsigned framebuffer_ = 0, many_framebuffer_ = 0, many_colour_ = 0, depth_ = 0;
  int samples_ = 1;
};

// A triangle that covers the viewport; the program's vertex shader is kFullScreen.
class FullScreen {
 public:
  FullScreen();
  ~FullScreen();
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;
  void draw() const;

 private:
  unsigned array_ = 0;
};
extern const char* const kFullScreen;

}  // namespace palpate::render
