// Lines, circles and pictures on a canvas.
//
// Pixels of the canvas, x right, y down; places are real numbers, (0, 0) is the corner of the first pixel. What lies
// beyond the canvas is not drawn, however far; what is not a number is not drawn at all. Pure functions.
#pragma once

#include <Eigen/Core>
#include <span>

#include "palpate/desktop/canvas.h"
#include "palpate/desktop/letterbox.h"

namespace palpate::desktop {

void draw_line(Canvas& canvas, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
               const Colour& colour);
// Dashes of `dash` pixels, and gaps as long.
void draw_dashes(Canvas& canvas, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
                 double dash, const Colour& colour);
void draw_disc(Canvas& canvas, const Eigen::Vector2d& centre, double radius, const Colour& colour);
void draw_ring(Canvas& canvas, const Eigen::Vector2d& centre, double radius, double width,
               const Colour& colour);
// Convex or not, without holes.
void fill_polygon(Canvas& canvas, std::span<const Eigen::Vector2d> corners, const Colour& colour);
// Packed RGB, row 0 on top, as large as the box; it covers what is below.
void draw_picture(Canvas& canvas, std::span<const std::uint8_t> rgb, Size picture, const Box& box);
// Lays a canvas over another.
void put(Canvas& canvas, const Canvas& piece, int x, int y);
// As a picture, for a window.
void to_rgb(const Canvas& canvas, std::vector<std::uint8_t>& rgb);

}  // namespace palpate::desktop
